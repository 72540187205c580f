/* asperity for C: contact between two rough surfaces of spherical asperities.
 *
 *   gcc press.c -I include -L FOLDER -l:libasperity.so.1 -Wl,-rpath,FOLDER
 *
 * Every call that does work gives one outcome, a handle. It holds all that the call brought: tables
 * of columns, texts, or what went wrong. asperity_status says which. Free it with asperity_free;
 * all that was got from it (texts, columns) belongs to it and goes with it, and nothing else is
 * ever to be freed. A handle is NULL only where memory has ended; every function takes NULL then,
 * and asperity_status says that nothing could be computed.
 *
 * Nothing is printed and no call ends the process, but for one case: where memory ends in the
 * middle of the work, beyond what is asked for before it, the run-time library of the Fortran
 * compiler ends it.
 *
 * Threads: nothing is remembered between calls. Calls may run at once in several threads, also on
 * the same scene: solves run in parallel, other calls take turns. One outcome must not be freed while
 * another thread uses it.
 *
 * Every argument is checked. One that is refused gives an outcome with ASPERITY_BAD_INPUT, whose text
 * names the argument as it is called here, says what was found and what is expected. Pointers may be
 * NULL where it is said below; elsewhere NULL is refused, too.
 *
 * Units: any consistent set, as in a scene file. With mm and N, moduli and pressures are N/mm2.
 * A card deck brings cm, N and N/cm2. Angles are radians. Texts are UTF-8 and end with a null
 * character; arrays have one cell a row, without gaps.
 */
#ifndef ASPERITY_H
#define ASPERITY_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct asperity_outcome asperity_outcome;

/* What became of a call. */
enum {
  ASPERITY_DONE = 0,         /* the chosen model was solved to the stated tolerance */
  ASPERITY_NOT_COMPUTED = 1, /* ASPERITY_FAILURE says why */
  ASPERITY_BAD_INPUT = 2     /* asperity_get_problem or ASPERITY_PROBLEMS says all that is wrong */
};

/* Texts of an outcome. */
enum {
  ASPERITY_FAILURE = 1,  /* why it could not be computed, one line */
  ASPERITY_PROBLEMS = 2, /* a line a problem: FILE:LINE:COLUMN: what is wrong, found, expected */
  ASPERITY_WARNINGS = 3, /* a line a kind: what was computed but lies outside a theory */
  ASPERITY_NOTES = 4,    /* a line each: oddities of a deck that are no errors */
  ASPERITY_REPORT = 5,   /* the report, of asperity_make_report; else the summary of the program */
  ASPERITY_WARNING_KINDS = 6, /* a line for each line of ASPERITY_WARNINGS: NAME CLASS, for instance
                                 "overlapping theory" or "error accuracy": outside the range of a
                                 theory, or numbers in error */
  ASPERITY_UNIT = 7,          /* asperity_read_map, asperity_generate_map, asperity_power_spectrum,
                                 asperity_fields: unit of all lengths; "" where the map has none */
  ASPERITY_GROUPS = 8,        /* of a scene, a line a name: GROUP, NAME and VALUES as they stand in its
                                 text, with tabulators between and values on one line. A card deck has
                                 the lines of the scene that says the same. Names of files are
                                 relative to the scene's file */
  ASPERITY_SCENE = 9,         /* asperity_solve_scene: an object of JSON with "scene" (file, text, units)
                                 and "provenance" as docs/results.schema.json has them */
  ASPERITY_METHODS = 10       /* asperity_study_scene: the lines of asperity accuracy --csv */
};

/* Tables of an outcome, with the columns of the CSV files. A cell that was not computed is NaN. */
enum {
  ASPERITY_POSITIONS = 1,  /* asperity_solve_scene: a row a position, its last state */
  ASPERITY_STATES = 2,     /* asperity_solve_scene: a row a state on the way */
  ASPERITY_CONTACTS = 3,   /* asperity_solve_scene: a row a contact, of every state */
  ASPERITY_SUMMITS = 4,    /* asperity_summits: x, y, height, radius */
  ASPERITY_STATISTICS = 5, /* asperity_summits: one row */
  ASPERITY_UPPER = 6,      /* asperity_generate: x, y, height, radius */
  ASPERITY_LOWER = 7,      /* asperity_generate: x, y, height, radius */
  ASPERITY_MAP = 8,        /* asperity_read_map, asperity_generate_map, asperity_fields: columns, rows,
                              spacing_x, spacing_y; of asperity_fields also origin_x, origin_y, the
                              centre of the first pixel, periodic_x, periodic_y, and boundary_contacts, hertz_contacts, how
                              many contacts have the pressure of boundary elements and of Hertz, -1 on
                              a height map; one row */
  ASPERITY_PIXELS = 9,     /* asperity_read_map, asperity_generate_map: height, of rows * columns pixels,
                              row by row; NaN where
                              one is missing */
  ASPERITY_FIELDS = 10,    /* asperity_fields: pressure, gap of the deformed surfaces (0 in contact),
                              displacement of both surfaces (more than 0 apart from each other),
                              contact (1 or 0), of rows * columns pixels, row by row; NaN where a pixel
                              is missing. With friction on pixels also traction_x, traction_y on the lower
                              body, slip_x, slip_y of the upper over the lower body, stick (1 or 0) */
  ASPERITY_SPECTRUM = 11,  /* asperity_power_spectrum: of the area, averaged over rings: q, c_iso, number
                              of wave vectors of each ring */
  ASPERITY_SPECTRUM_X = 12, /* of lines along x: q, c_1d, number of lines */
  ASPERITY_SPECTRUM_Y = 13  /* of lines along y: q, c_1d, number of lines */
};

/* What the cells of a column are. */
enum {
  ASPERITY_DOUBLE = 1, /* double */
  ASPERITY_INT = 2,    /* int; for yes and no, 1 and 0 */
  ASPERITY_WORD = 3    /* char[ASPERITY_WORD_LENGTH], blanks behind the word, no null character */
};
#define ASPERITY_WORD_LENGTH 16

/* One surface: summits of spherical asperities, lengths in the unit of the scene. All numbers are
 * finite, and no pointer is NULL unless count is 0. The numbers are copied: they may go when
 * asperity_build_scene has come back. */
typedef struct {
  int count;            /* asperities; 0: a plane, and the rest is not looked at */
  int radii;            /* how many radii: count, or 1 for all */
  const double *x, *y;  /* [count] places on the reference plane */
  const double *height; /* [count] above the reference plane, less than twice the radius */
  const double *radius; /* [radii] of the summits, more than 0 */
} asperity_surface;

/* A height map. The heights are copied: they may go when the function has come back. */
typedef struct {
  int columns, rows;    /* pixels along x and along y, at least 3 of each */
  const double *height; /* [rows][columns], y grows with the row; NaN: missing; at most 1e30 */
  double spacing[2];    /* of pixels along x and y, from 1e-30 to 1e30; 0, 0: map_spacing of the scene,
                           or spacing of the options, has it */
  const char *unit;     /* of all lengths: "m", "mm", "um", "nm", "cm" or "in"; NULL or "": none */
  int periodic;         /* 1: it repeats itself along x and y; 0: it is free; -1: not known, free unless
                           the scene or the other map has an edge */
} asperity_height_map;

/* One side of a scene, as asperities or as a map; with NULL for both the text names it. */
typedef struct {
  const asperity_surface *asperities;
  const asperity_height_map *map;
} asperity_side;

/* How a scene is solved. All bytes zero: the defaults. */
typedef struct {
  const char *arithmetic; /* "real64" or NULL: no other; asperity_make_report has other arithmetics */
  double accuracy;        /* relative error that is allowed, less than 1: the fastest method that has it
                             is taken; 0: none is asked for */
  int totals_only;        /* not 0: contacts are not kept, their table has no rows */
  int threads;            /* at most 9999; 0: as many as OpenMP gives; the results are the same for
                             any number */
  const int *interrupt;   /* NULL, or a number that another thread or a signal's handler makes other
                             than 0 to end the call: it goes no further than the states that are
                             under way, and fails with "interrupted" */
  const char *accuracy_of; /* results that `accuracy` limits: "load" (also for NULL; the separation and
                              compression under a load), "area", "pressure" (the greatest, of height
                              maps), or "all" (load and area) */
  int *progress;          /* NULL, or two numbers that other threads may read at any time: states
                             that are done, and all of them, 0 as long as that is not known. They
                             begin anew where a scene is solved in several ways */
  int fields;             /* kept for asperity_fields: 0 none, 1 those of the last state of the
                             path, 2 those of all states, of 24 bytes a pixel and state. A scene of
                             asperities has them on a grid where &surfaces has field_spacing, and
                             one position; fields of another scene are refused before it is solved */
} asperity_options;

/* How summits are found. All bytes zero: the defaults. */
typedef struct {
  const char *rule;   /* "eight" (also for NULL) or "contact" */
  const char *level;  /* "plane", "mean" or "none"; NULL: plane for a free map, mean for a periodic
                         one */
  const char *radius; /* "neighbours", "geometric" or "paraboloid"; NULL: that of the rule */
  const char *unit;   /* "m", "mm", "um", "nm", "cm" or "in": lengths are converted to it, or, of a map
                         without a unit, are in it; NULL: that of the map */
  double spacing[2];  /* along x and y, from 1e-30 to 1e30, of a map without a spacing: a matrix in a
                         text file, an array; 0 for other maps */
  int despike;        /* not 0: single outliers are removed */
  int periodic;       /* not 0: the map of a file repeats itself along x and y */
} asperity_summits_options;

/* A half-space under pixels, with a layer that is bonded to it, or without. */
typedef struct {
  int columns, rows;   /* pixels along x and along y */
  double spacing[2];   /* of pixels along x and y */
  int periodic[2];     /* 1: it repeats itself along x, y; 0: no load beyond the pixels */
  double modulus[2];   /* Young's, at the surface and of the base; base 0: rigid */
  double ratio[2];     /* Poisson's, of both */
  double layer;        /* thickness; 0: none, and the base is not looked at */
} asperity_half_space;

/* One thing that is wrong with an input. */
typedef struct {
  const char *file; /* as it was named; "" where the problem is of no file */
  int line;         /* from 1; 0 where it has none */
  int column;       /* bytes, from 1; 0 where it has none */
  const char *text; /* what is wrong, what was found, what is expected */
} asperity_problem;

/* As "0.4.0". Never freed. */
const char *asperity_get_version(void);

/* Reads a scene file, or a card deck, with the files that it names. */
asperity_outcome *asperity_read_scene(const char *scene);

/* A scene from the text of its groups, "&material ... / &loading ... /", and two sides: asperities,
 * height maps, or NULL: &surfaces of the text has upper or lower = 'FILE' or 'plane' then. &surfaces
 * may have nominal_area, units, radius and all names of maps; map_edge has precedence over the edge
 * of a map. Messages call the text "scene". */
asperity_outcome *asperity_build_scene(const char *groups, const asperity_side *upper,
                                       const asperity_side *lower);

/* Solves a scene: an outcome of asperity_read_scene, _build_scene or _rebuild_scene, which stays as it
 * is and may be freed afterwards. What is wrong with the scene is wrong with this outcome, too: it is
 * enough to ask here. options may be NULL. */
asperity_outcome *asperity_solve_scene(const asperity_outcome *scene,
                                       const asperity_options *options);

/* Run time and error of each method of a scene, as `asperity accuracy` has them: texts ASPERITY_REPORT
 * and ASPERITY_METHODS. seconds: time that may be spent, more than 0. finest: 1, or
 * 2: a height map on pixels half as wide, too. */
asperity_outcome *asperity_study_scene(const asperity_outcome *scene, double seconds, int finest);

/* A scene with the surfaces of another scene, which are not read again, and the text of all its
 * groups. &surfaces of the text is not looked at: nominal_area, units, map_level and so on keep their
 * values. Surfaces from a card deck are read again, as the deck brings material and slopes, too: the
 * text must have &surfaces then. Messages call the text by the file of the other scene. */
asperity_outcome *asperity_rebuild_scene(const asperity_outcome *scene, const char *groups);

/* Pressure, gap and displacement of one state that was kept: tables ASPERITY_MAP and ASPERITY_FIELDS,
 * text ASPERITY_UNIT. solved: outcome of asperity_solve_scene. position: from 1. state: from 1, or
 * -1 for the last. */
asperity_outcome *asperity_fields(const asperity_outcome *solved, int position, int state);

/* A body under a pressure and tractions along x and y on each pixel, row by row; NaN: a missing pixel;
 * tractions NULL: none. Table ASPERITY_FIELDS, by what:
 * ASPERITY_DISPLACEMENTS of the surface: displacement_z, more than 0 into the body, and with tractions
 * displacement_x, displacement_y. On a periodic side their mean is 0, but on a layer with a rigid base.
 * ASPERITY_PRESSURES: pressure, for values that are displacements along z.
 * ASPERITY_STRESSES at a depth of 0 or more: stress_xx, yy, zz, xy, xz, yz, von_mises, largest_shear;
 * tension is positive, z points into the body.
 * Tractions of asperity_fields act on the lower body, those on the upper one are opposite. */
enum { ASPERITY_DISPLACEMENTS = 1, ASPERITY_PRESSURES = 2, ASPERITY_STRESSES = 3 };
asperity_outcome *asperity_loaded(const asperity_half_space *body, int what, const double *values,
                                  const double *traction_x, const double *traction_y, double depth);

/* Runs the original program on a card deck; ASPERITY_REPORT is what it prints. arithmetic: "ibm370"
 * (also for NULL), "real32", "real64" or "real128". tables: [number] positions from 1 to 100, whose
 * contact tables are printed; NULL: those of the thesis, 13, 55 and 56. */
asperity_outcome *asperity_make_report(const char *deck, const char *arithmetic,
                                       const int *tables, int number);

/* Finds the summits of a height map: of a file, or, where heights is not NULL, of one in memory with the
 * edge that it has. options may be NULL. */
asperity_outcome *asperity_summits(const char *map, const asperity_height_map *heights,
                                   const asperity_summits_options *options);

/* Reads a height map of any format: its size and spacing, its pixels, its unit, notes. spacing: [2] along
 * x and y, for a map without a spacing; else NULL. unit: lengths are converted to it, or, of a map
 * without a unit, are in it; NULL: that of the map. Heights are not levelled. */
asperity_outcome *asperity_read_map(const char *map, const double *spacing, const char *unit);

/* Writes a height map with all its bits. The ending of the path chooses the format: .sdf (ISO 25178-71,
 * binary; a unit and a spacing are needed), .npy (array of doubles), .txt (matrix, spacing and unit as
 * comments). */
asperity_outcome *asperity_write_map(const asperity_height_map *map, const char *path);

/* Power spectral densities of a map, levelled first: level is "plane", "mean", "none", or NULL: without its
 * plane where it is free, without its mean where it is periodic. A free map has a Hann window. q: wave
 * number, 2 pi over the wavelength, 1/length; c_iso: length to the power 4; c_1d: length to the power 3.
 * Missing pixels are refused. */
asperity_outcome *asperity_power_spectrum(const asperity_height_map *map, const char *level);

/* Makes the random height map of a specification with a group &map: of a file, or, where groups is not
 * NULL, of the text of its groups. Tables and text are those of asperity_read_map; ASPERITY_MAP has the
 * column periodic, 1 or 0, too. */
asperity_outcome *asperity_generate_map(const char *specification, const char *groups);

/* Makes the two random surfaces of a specification: of a file, or, where groups is not NULL, of the
 * text of its groups. surface: which of the ensemble, from 1. */
asperity_outcome *asperity_generate(const char *specification, const char *groups, int surface);

/* ASPERITY_DONE, ASPERITY_NOT_COMPUTED or ASPERITY_BAD_INPUT. */
int asperity_status(const asperity_outcome *outcome);

/* One of the texts; "" where there is none. Never NULL. */
const char *asperity_text(const asperity_outcome *outcome, int which);

/* How many problems there are, and one of them, counted from 0. */
int asperity_problem_count(const asperity_outcome *outcome);
void asperity_get_problem(const asperity_outcome *outcome, int number, asperity_problem *problem);

/* Rows and columns of a table; 0 where it is not there. */
int64_t asperity_rows(const asperity_outcome *outcome, int table);
int asperity_columns(const asperity_outcome *outcome, int table);

/* A column, counted from 0: its name, what its cells are, and the cells themselves, as many as the
 * table has rows: const double *, const int *, or const char (*)[ASPERITY_WORD_LENGTH]. NULL where
 * there is none. */
const char *asperity_column_name(const asperity_outcome *outcome, int table, int column);
int asperity_column_type(const asperity_outcome *outcome, int table, int column);
const void *asperity_column(const asperity_outcome *outcome, int table, int column);

/* Unit of a column, for instance "N/mm2"; "" for plain numbers, and where no unit is known or there is
 * no such column. Never NULL. */
const char *asperity_column_unit(const asperity_outcome *outcome, int table, int column);

/* Frees an outcome; NULL is left alone. */
void asperity_free(asperity_outcome *outcome);

#ifdef __cplusplus
}
#endif
#endif
