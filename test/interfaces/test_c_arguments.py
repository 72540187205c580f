"""What C gives the library: null pointers, counts and numbers out of range, under valgrind."""

import shutil

import pytest
from builds import ROOT
from programs import run_program

pytestmark = pytest.mark.once

PROGRAM = r"""
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "asperity.h"

static int wrong = 0;

/* An outcome must have this status, and say this. */
static asperity_outcome *expect(int status, const char *text, asperity_outcome *outcome)
{
  int text_number = status == ASPERITY_BAD_INPUT ? ASPERITY_PROBLEMS : ASPERITY_FAILURE;
  const char *found = asperity_text(outcome, text_number);
  if (asperity_status(outcome) != status || !strstr(found, text)) {
    printf("line of '%s': status %d, %s\n", text, asperity_status(outcome), found);
    wrong++;
  }
  return outcome;
}

static void refused(const char *text, asperity_outcome *outcome)
{
  asperity_free(expect(ASPERITY_BAD_INPUT, text, outcome));
}

#define MAP_GROUP "&map pixels = 10, 8, spacing = 1., hurst = 1., rms_slope = 1., unit = 'nm' /"
#define GROUPS "&material contact_modulus = 1e3 / &loading control = 'load', value = 1. /"

static void surface(const char *text, int count, int radii, const double *x, const double *y,
                    const double *height, const double *radius)
{
  const asperity_surface bad = {count, radii, x, y, height, radius}, plane = {0, 0, 0, 0, 0, 0};
  const asperity_side upper = {&bad, NULL}, lower = {&plane, NULL};
  asperity_outcome *scene = expect(ASPERITY_BAD_INPUT, text,
                                   asperity_build_scene(GROUPS, &upper, &lower));
  refused(text, asperity_solve_scene(scene, NULL));
  asperity_free(scene);
}

static void option(const char *text, const asperity_outcome *scene, double accuracy, int threads,
                   const char *arithmetic)
{
  const asperity_options options = {arithmetic, accuracy, 0, threads, NULL, NULL, NULL, 0};
  refused(text, asperity_solve_scene(scene, &options));
}

static void map(const char *text, const char *path, double along_x, double along_y)
{
  asperity_summits_options options = {NULL, NULL, NULL, NULL, {along_x, along_y}, 0, 0};
  refused(text, asperity_summits(path, NULL, &options));
}

static void map_beside_plane(const char *text, asperity_height_map bad)
{
  const asperity_side side = {NULL, &bad};
  refused(text, asperity_build_scene(GROUPS " &surfaces upper = 'plane' /", NULL, &side));
}

int main(int words, char **word)
{
  const double x[] = {0., 1.}, y[] = {0., 0.}, z[] = {.1, .1}, r[] = {1., 1.};
  const double high[] = {.1, 2.}, flat[] = {1., 0.}, endless[] = {1., INFINITY}, none[] = {0., NAN};
  const asperity_surface good = {2, 2, x, y, z, r}, plane = {0, 0, NULL, NULL, NULL, NULL};
  const asperity_side balls = {&good, NULL}, flat_side = {&plane, NULL};
  const int tables[] = {13, 101};
  int progress[2] = {0, 0};
  asperity_problem problem = {NULL, 0, 0, NULL};
  asperity_outcome *made, *spectra;
  (void)words;

  refused("scene: found NULL, expected a path", asperity_read_scene(NULL));
  refused("scene: found an empty text", asperity_read_scene(""));
  refused("groups: found NULL, expected a text", asperity_build_scene(NULL, NULL, NULL));
  refused("groups: found NULL, expected a text", asperity_build_scene(NULL, &balls, &flat_side));
  refused("a surface is missing", asperity_build_scene(GROUPS, &balls, NULL));
  refused("a surface is missing", asperity_build_scene(GROUPS, NULL, &balls));
  refused("found two planes", asperity_build_scene(GROUPS, &flat_side, &flat_side));
  surface("surfaces.upper.x: found NULL, expected numbers", 2, 2, NULL, y, z, r);
  surface("surfaces.upper.y: found NULL, expected numbers", 2, 2, x, NULL, z, r);
  surface("surfaces.upper.height: found NULL, expected numbers", 2, 2, x, y, NULL, r);
  surface("surfaces.upper.radius: found NULL, expected numbers", 2, 1, x, y, z, NULL);
  surface("surfaces.upper.radius: found NULL, expected numbers", 2, 2, NULL, NULL, NULL, NULL);
  surface("surfaces.upper.count: found -1, expected 0 for a plane", -1, 1, x, y, z, r);
  surface("surfaces.upper.radii: found 3, expected 1 or 2", 2, 3, x, y, z, r);
  surface("surfaces.upper.radii: found 0, expected 1 or 2", 2, 0, x, y, z, r);
  surface("surfaces.upper.radii: found -7, expected 1 or 2", 2, -7, x, y, z, r);
  surface("surfaces.upper.x: found Infinity as number 2 of 2, expected a f",
          2, 2, endless, y, z, r);
  surface("surfaces.upper.y: found NaN as number 2 of 2, expected a finite", 2, 2, x, none, z, r);
  surface("surfaces.upper.radius: found 0.", 2, 2, x, y, z, flat);
  surface("surfaces.upper.radius: found Infinity", 2, 2, x, y, z, endless);
  surface("surfaces.upper.height: found 2.000000E+000 as number 2 of 2, expected less than twice",
          2, 2, x, y, high, r);

  asperity_outcome *scene = asperity_build_scene(GROUPS, &balls, &flat_side);
  option("accuracy: found NaN, expected a relative error", scene, NAN, 0, NULL);
  option("accuracy: found Infinity, expected", scene, INFINITY, 0, NULL);
  option("accuracy: found -1.", scene, -1., 0, NULL);
  option("accuracy: found 1.", scene, 1., 0, NULL);
  option("threads: found -1, expected a number from 1 to 9999", scene, 0., -1, NULL);
  option("threads: found 10000, expected", scene, 0., 10000, NULL);
  option("arithmetic: found real128, expected real64", scene, 0., 0, "real128");
  option("arithmetic: found , expected real64", scene, 0., 0, "");
  asperity_outcome *solved = expect(ASPERITY_DONE, "", asperity_solve_scene(scene, NULL));
  asperity_free(expect(ASPERITY_NOT_COMPUTED, "no scene", asperity_solve_scene(NULL, NULL)));
  asperity_free(expect(ASPERITY_NOT_COMPUTED, "no scene", asperity_solve_scene(solved, NULL)));

  refused("deck: found NULL, expected a path", asperity_make_report(NULL, NULL, NULL, 0));
  refused("tables: found 101, expected positions", asperity_make_report(word[1], NULL, tables, 2));
  refused("number: found -1, expected 0 or more", asperity_make_report(word[1], NULL, tables, -1));
  refused("map: found NULL, expected a path", asperity_summits(NULL, NULL, NULL));
  map("spacing: found Infinity, 1.", word[2], INFINITY, 1.);
  map("spacing: found NaN, 1.", word[2], NAN, 1.);
  map("spacing: found 1.000000E-160, 1.", word[2], 1e-160, 1e-160);
  map("spacing: found 1.000000E+031, 1.", word[2], 1e31, 1.);
  map("spacing: found -1.", word[2], -1., 1.);
  map("spacing: found 0.", word[2], 0., 1.);
  /* Maps as arrays. The heights are of the size that is stated, no larger. */
  double heights[12] = {0., 1., 0., 2., 1., NAN, 3., 1., 0., 1., 2., 0.};
  asperity_height_map area = {3, 4, heights, {.5, .25}, "um", -1}, bad = area;
  const asperity_side map_side = {NULL, &area}, both = {&good, &area}, none_given = {NULL, NULL};
  asperity_outcome *pixels = expect(ASPERITY_DONE, "", asperity_build_scene(
    GROUPS " &effects interaction = 'boundary' / &surfaces upper = 'plane' /", NULL, &map_side));
  asperity_free(expect(ASPERITY_DONE, "", asperity_solve_scene(pixels, NULL)));
  /* Fields: none without being asked for, the last state, all. */
  refused("solved: found NULL, expected the outcome of a solve", asperity_fields(NULL, 1, 1));
  asperity_options kept = {NULL, 0., 0, 0, NULL, NULL, progress, 3};
  refused("fields: found 3, expected 0 for none", asperity_solve_scene(pixels, &kept));
  kept.fields = -1;
  refused("fields: found -1, expected 0 for none", asperity_solve_scene(pixels, &kept));
  if (progress[0] || progress[1]) wrong++;
  asperity_free(expect(ASPERITY_NOT_COMPUTED, "no fields: expected a height map",
                       asperity_fields(solved, 1, 1)));
  for (int asked = 0; asked < 3; asked++) {
    kept.fields = asked;
    asperity_outcome *pressed = expect(ASPERITY_DONE, "", asperity_solve_scene(pixels, &kept));
    if (progress[0] != 1 || progress[1] != 1) wrong++;
    if (asked) {
      asperity_outcome *fields = expect(ASPERITY_DONE, "", asperity_fields(pressed, 1, -1));
      const double *pressure = asperity_column(fields, ASPERITY_FIELDS, 0);
      const double *gap = asperity_column(fields, ASPERITY_FIELDS, 1);
      const int *contact = asperity_column(fields, ASPERITY_FIELDS, 3);
      double load = 0.;
      if (asperity_rows(fields, ASPERITY_FIELDS) != 12 ||
          asperity_columns(fields, ASPERITY_FIELDS) != 4 ||
          *(const int *)asperity_column(fields, ASPERITY_MAP, 1) != 4 ||
          strcmp(asperity_text(fields, ASPERITY_UNIT), "um") ||
          strcmp(asperity_column_name(fields, ASPERITY_FIELDS, 2), "displacement") ||
          strcmp(asperity_column_unit(fields, ASPERITY_FIELDS, 1), "um"))
        wrong++;
      for (int i = 0; i < 12; i++) {
        if (i == 5 && pressure[i] == pressure[i]) wrong++;
        if (i == 5) continue;
        load += pressure[i] * .5 * .25;
        if (contact[i] != (pressure[i] > 0.) || (contact[i] ? gap[i] != 0. : gap[i] < 0.)) wrong++;
      }
      if (!(load > 1. - 1e-12 && load < 1. + 1e-12)) wrong++;
      asperity_free(fields);
      asperity_free(expect(ASPERITY_DONE, "", asperity_fields(pressed, 1, 1)));
      refused("state: found 2, expected 1, or -1 for the last", asperity_fields(pressed, 1, 2));
      refused("position: found 2, expected 1", asperity_fields(pressed, 2, -1));
    } else {
      asperity_free(expect(ASPERITY_NOT_COMPUTED, "no fields: expected a height map",
                           asperity_fields(pressed, 1, -1)));
    }
    asperity_free(pressed);
  }
  asperity_free(pixels);
  made = expect(ASPERITY_DONE, "", asperity_summits(NULL, &area, NULL));
  for (int i = 0; i < asperity_columns(made, ASPERITY_STATISTICS); i++) {
    const char *unit = asperity_column_unit(made, ASPERITY_STATISTICS, i);
    const char *name = asperity_column_name(made, ASPERITY_STATISTICS, i);
    if ((!strcmp(name, "density") && strcmp(unit, "1/um2")) ||
        (!strcmp(name, "m0") && strcmp(unit, "um2")) ||
        (!strcmp(name, "mean_curvature") && strcmp(unit, "1/um")) ||
        (!strcmp(name, "alpha") && *unit) || (!strcmp(name, "m2_x") && *unit))
      wrong++;
  }
  asperity_free(made);
  asperity_free(expect(ASPERITY_DONE, "", asperity_read_map(word[2], area.spacing, "mm")));
  asperity_free(expect(ASPERITY_DONE, "", asperity_write_map(&area, "a.npy")));
  refused("surfaces.upper: found asperities and a map",
          asperity_build_scene(GROUPS, &both, NULL));
  refused("no surfaces: found no group", asperity_build_scene(GROUPS, &none_given, NULL));
  refused("a surface is missing", asperity_build_scene(GROUPS, &map_side, &none_given));
  refused("groups: found NULL", asperity_build_scene(NULL, &map_side, &map_side));
  refused("map: found NULL, expected a path", asperity_read_map(NULL, NULL, NULL));
  refused("unit: found ell, expected one of m", asperity_read_map(word[2], area.spacing, "ell"));
  refused("path: found NULL, expected a path", asperity_write_map(&area, NULL));
  bad.columns = 0;
  map_beside_plane("surfaces.lower.columns: found 0, expected 3 or more", bad);
  bad.columns = 2147483647;
  bad.rows = 2;
  map_beside_plane("surfaces.lower: found 2147483647 x 2", bad);
  bad = area;
  bad.periodic = 2;
  map_beside_plane("surfaces.lower.periodic: found 2, expected 1, 0, or -1", bad);
  bad = area;
  bad.unit = "furlong";
  map_beside_plane("surfaces.lower.unit: found furlong, expected one of m, mm, um", bad);
  bad = area;
  bad.spacing[0] = NAN;
  map_beside_plane("surfaces.lower.spacing: found NaN, ", bad);
  bad = area;
  bad.height = NULL;
  map_beside_plane("surfaces.lower.height: found NULL", bad);
  refused("map.height: found NULL, expected numbers", asperity_write_map(&bad, "a.npy"));
  refused("map: found NULL", asperity_write_map(NULL, NULL));
  bad = area;
  bad.rows = -1;
  refused("map.rows: found -1, expected 3 or more", asperity_summits(NULL, &bad, NULL));
  bad = area;
  bad.spacing[1] = 0.;
  refused("map.spacing: found 5.", asperity_summits(NULL, &bad, NULL));

  refused("specification: found NULL, expected a path", asperity_generate(NULL, NULL, 1));
  refused("specification: found NULL, expected a path", asperity_generate_map(NULL, NULL));
  refused("specification:1:1: &map needs pixels", asperity_generate_map(NULL, "&map hurst = 1. /"));
  refused("found a height map, expected surfaces", asperity_generate(NULL, MAP_GROUP, 1));
  refused("map: found NULL, expected a height map", asperity_power_spectrum(NULL, NULL));
  bad.spacing[0] = 0.;
  refused("map.spacing: found 0, 0, expected the spacing", asperity_power_spectrum(&bad, NULL));
  made = expect(ASPERITY_DONE, "", asperity_generate_map(NULL, MAP_GROUP));
  if (asperity_rows(made, ASPERITY_PIXELS) != 80 || asperity_columns(made, ASPERITY_MAP) != 5 ||
      strcmp(asperity_text(made, ASPERITY_UNIT), "nm"))
    wrong++;
  area.columns = 10;
  area.rows = 8;
  area.height = asperity_column(made, ASPERITY_PIXELS, 0);
  spectra = expect(ASPERITY_DONE, "", asperity_power_spectrum(&area, "mean"));
  if (asperity_rows(spectra, ASPERITY_SPECTRUM_X) != 4 ||
      asperity_rows(spectra, ASPERITY_SPECTRUM_Y) != 3 ||
      strcmp(asperity_column_name(spectra, ASPERITY_SPECTRUM, 1), "c_iso"))
    wrong++;
  asperity_free(spectra);
  asperity_free(made);
  refused("surface: found 0, which is not in the ensemble", asperity_generate(
    NULL, "&surfaces number = 9, length = 1., width = 1. / &heights mean = 1., deviation = 1. /"
    "&radii mean = 9. /", 0));

  /* What looks at an outcome. */
  asperity_get_problem(scene, 0, NULL);
  asperity_get_problem(NULL, -1, &problem);
  if (!problem.file || !problem.text || *problem.file || *problem.text) wrong++;
  for (int which = -1; which < 15; which++) {
    if (!asperity_text(NULL, which) || !asperity_text(solved, which)) wrong++;
    if (*asperity_column_unit(NULL, which, 0)) wrong++;
    if (asperity_rows(NULL, which) || asperity_columns(NULL, which)) wrong++;
    if (asperity_column(NULL, which, 0) || asperity_column(solved, which, -1)) wrong++;
    if (asperity_column_name(solved, which, 1000) || asperity_column(solved, which, 1000)) wrong++;
  }
  if (asperity_problem_count(NULL)) wrong++;
  asperity_free(NULL);
  asperity_free(solved);
  asperity_free(scene);
  return wrong;
}
"""


@pytest.mark.long
def test_bad_arguments_under_valgrind(venv, tmp_path):
    """Each is refused with a status and a text that names it; nothing that is not there is read,
    and nothing is left over."""
    library = next(venv.glob("lib/python*/site-packages/asperity"))
    (tmp_path / "a.c").write_text(PROGRAM)
    run_program("gcc", "-std=c99", "-pedantic", "-g", "-Wall", "-Wextra", "-Werror", "-I",
                ROOT / "include", "a.c", "-o", "a", "-L", library, "-l:libasperity.so.1",
                f"-Wl,-rpath,{library}", cwd=tmp_path)
    (tmp_path / "m.txt").write_text("0 1 0\n1 3 1\n0 1 0\n")
    words = [tmp_path / "a", ROOT / "data/thesis.deck", tmp_path / "m.txt"]
    done = run_program(*words, cwd=tmp_path)
    assert done.stdout == done.stderr == "", done.stdout + done.stderr
    if not shutil.which("valgrind"):
        pytest.skip("no valgrind here (bash .ci/setup trouble)")
    run_program("valgrind", "-q", "--error-exitcode=99", "--leak-check=full",
                "--errors-for-leak-kinds=definite,indirect", *words,
                variables={"OMP_NUM_THREADS": "1"}, cwd=tmp_path)
