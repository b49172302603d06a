/* The three parts, the tool and the footprint of the VCRF paper (see tests/data/reference). */
#include "conformance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static FILE *open_data(const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s/reference/%s", data_directory, name);
    FILE *file = fopen(path, "r");
    if (!file) {
        fprintf(stderr, "conformance: cannot open %s; give --data\n", path);
        exit(2);
    }
    return file;
}

/* The numbers of a line; words count as NaN. */
static int numbers(char *line, double *out, int most) {
    int n = 0;
    for (char *at = line; at && n < most; n++) {
        char *end, *comma = strchr(at, ',');
        if (comma) *comma = 0;
        out[n] = strtod(at, &end);
        if (end == at) out[n] = NAN;
        at = comma ? comma + 1 : NULL;
    }
    return n;
}

typedef struct correction {
    int part;
    double x, y, tilt;
} correction;

static int read_corrections(correction *list, int most) {
    FILE *file = open_data("corrections.csv");
    char line[256];
    int n = 0;
    while (n < most && fgets(line, sizeof line, file)) {
        double v[4];
        int part = 0;
        while (part < MODEL_PAPERS &&
               strncmp(line, model_paper_name[part], strlen(model_paper_name[part])) != 0)
            part++;
        if (part < MODEL_PAPERS && numbers(line, v, 4) == 4)
            list[n++] = (correction){part, v[1], v[2], v[3]};
    }
    fclose(file);
    return n;
}

/* The answer of geometry section 4: the smaller of the tilt away from P and the limit at P. */
static double true_tilt(int part, const double *row, const correction *list, int n) {
    for (int i = 0; i < n; i++)
        if (list[i].part == part && list[i].x == row[0] && list[i].y == row[1]) return list[i].tilt;
    return isnan(row[13]) ? row[8] : fmin(row[8], row[13]);
}

/* BTG_TEST_QUICK: every fifth position. */
static int stride(void) {
    const char *quick = getenv("BTG_TEST_QUICK");
    return quick && *quick && *quick != '0' ? 5 : 1;
}

static void make(fixture *f, int part, btg_profile profile, const char *suffix) {
    correction list[128];
    int corrections = read_corrections(list, 128);
    fixture_tool(f, 6.7, 6, profile);
    model_paper(&f->model, part);
    fixture_part(f);
    char name[64], line[1024];
    snprintf(name, sizeof name, "%s-%s.csv", model_paper_name[part], suffix);
    FILE *file = open_data(name);
    for (int i = 0; fgets(line, sizeof line, file);) {
        double row[21];
        if (numbers(line, row, 21) != 21 || isnan(row[0])) continue;
        if (i++ % stride() != 0) continue;
        want w = known(row[3]);
        if (f->op == BTG_OP_TILT) {
            bool toroidal = profile == BTG_PROFILE_TOROIDAL;
            w = known(BTG_PI / 180 * (toroidal ? true_tilt(part, row, list, corrections) : row[8]));
            w.lever = INFINITY;
            w.at_most = !toroidal;
        }
        fixture_foot(f, row[0], row[1], w);
    }
    fclose(file);
}

static void convex(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 0, BTG_PROFILE_TOROIDAL, "toroidal");
}

static void concave(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 1, BTG_PROFILE_TOROIDAL, "toroidal");
}

static void saddle(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 2, BTG_PROFILE_TOROIDAL, "toroidal");
}

static void convex_bullnose(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 0, BTG_PROFILE_BULLNOSE, "bullnose");
}

static void concave_bullnose(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 1, BTG_PROFILE_BULLNOSE, "bullnose");
}

static void saddle_bullnose(fixture *f, rng *r, int round) {
    (void)r, (void)round;
    make(f, 2, BTG_PROFILE_BULLNOSE, "bullnose");
}

#define CHECKS (CHECK_VALUE | CHECK_CLEAR | CHECK_TOUCH | CHECK_TIGHT)

static const test_case cases[] = {
    {"papers-drop-convex", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1, "760 positions", convex},
    {"papers-drop-concave", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1, "760 positions", concave},
    {"papers-drop-saddle", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1, "760 positions", saddle},
    {"papers-drop-convex-bullnose", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1, "760 positions",
     convex_bullnose},
    {"papers-drop-concave-bullnose", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1,
     "760 positions, the flat down in the corners", concave_bullnose},
    {"papers-drop-saddle-bullnose", BTG_OP_DROP, TOLERANCE_F64, CHECKS, 1, "760 positions",
     saddle_bullnose},
    {"papers-tilt-convex", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1, "valleys from P to Q", convex},
    {"papers-tilt-concave", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1,
     "part and tool of nearly one curvature", concave},
    {"papers-tilt-saddle", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1, "Q often beside P", saddle},
    {"papers-tilt-convex-bullnose", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1,
     "the flat ends the tilt at P", convex_bullnose},
    {"papers-tilt-concave-bullnose", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1, "torus against flat",
     concave_bullnose},
    {"papers-tilt-saddle-bullnose", BTG_OP_TILT, TOLERANCE_F64, CHECKS, 1, "both ends of a tilt",
     saddle_bullnose},
};

const case_list cases_papers = {cases, sizeof cases / sizeof *cases};
