/* Presses nine bumps with a ball, from C: surfaces in memory, a coupled curve, contacts as arrays.
 * With the path of a scene: solves that, and prints its total load at every position.
 *
 *   fpm run --example press_two_surfaces [-- SCENE] */
#include <stdio.h>
#include <string.h>

#include "asperity.h"

/* The column of a table by its name; NULL when there is none of that name. */
static const void *column(const asperity_outcome *outcome, int table, const char *name)
{
  for (int i = 0; i < asperity_columns(outcome, table); i++)
    if (strcmp(asperity_column_name(outcome, table, i), name) == 0)
      return asperity_column(outcome, table, i);
  return NULL;
}

static asperity_outcome *ball_on_bumps(void)
{
  static const double ball[] = {0.1, 0.1, 0.01, 10.0}, radius = 2.0;
  double x[9], y[9], height[9];
  for (int i = 0; i < 9; i++) {
    x[i] = 0.2 * (i % 3);
    y[i] = 0.2 * (i / 3);
    height[i] = 0.005 + 0.0002 * (5 * i % 9);
  }
  const asperity_surface upper = {1, 1, ball, ball + 1, ball + 2, ball + 3};
  const asperity_surface lower = {9, 1, x, y, height, &radius};
  const asperity_side sides[2] = {{&upper, NULL}, {&lower, NULL}};
  return asperity_build_scene("&material elastic_modulus = 210e3, 70e3, poisson_ratio = 0.3, 0.33 /"
                              "&loading control = 'load', value = 25., points = 5 /"
                              "&effects interaction = 'coupled' /",
                              &sides[0], &sides[1]);
}

int main(int words, char **word)
{
  asperity_outcome *scene = words > 1 ? asperity_read_scene(word[1]) : ball_on_bumps();
  asperity_outcome *results = asperity_solve_scene(scene, NULL);
  asperity_free(scene);

  const int status = asperity_status(results);
  fputs(asperity_text(results, ASPERITY_PROBLEMS), stderr);
  fputs(asperity_text(results, ASPERITY_WARNINGS), stderr);
  if (status == ASPERITY_NOT_COMPUTED)
    fprintf(stderr, "%s\n", asperity_text(results, ASPERITY_FAILURE));

  const int table = words > 1 ? ASPERITY_POSITIONS : ASPERITY_STATES;
  const double *separation = column(results, table, "separation");
  const double *load = column(results, table, "load");
  for (int i = 0; i < asperity_rows(results, table); i++)
    printf("%24.16e %24.16e\n", separation[i], load[i]);
  asperity_free(results);
  return status;
}
