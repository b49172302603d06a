/* The same positions on every machine: `digest` prints some as hexadecimal numbers; `digest FILE`
 * holds its own against those that another build printed. */
#include "../unit/run_load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The core rounds alike everywhere; libm's sin, cos, atan2 and hypot may be off by an ulp. That is
 * 1e-14 mm on a part of 150 mm, and at the end of Newton's way, where the value is flat, decides
 * whether a last step is taken: 5e-13 measured. */
#define LIMIT 2e-12

#define STEPS_PER_KIND 2
#define KINDS          3 /* alone, after a neighbour, spun */
#define NUMBERS        8
#define LINE_BYTES     512

typedef struct line {
    int status;
    double number[NUMBERS]; /* drop, tip, axis, tilt */
} line;

typedef struct sums {
    int positions, same, cut_short, bad;
    double height, pose; /* greatest differences */
} sums;

static line line_of(const btg_position *p) {
    return (line){
        p->status,
        {p->drop_z_mm, p->tip.x, p->tip.y, p->tip.z, p->axis.x, p->axis.y, p->axis.z, p->tilt_rad}};
}

static void print(const line *l) {
    printf("%d", l->status);
    for (int i = 0; i < NUMBERS; i++)
        printf(" %a", l->number[i]);
    printf("\n");
}

static int read_line(FILE *file, line *l) {
    char text[LINE_BYTES], *at = text;
    if (!fgets(text, sizeof text, file)) return 0;
    l->status = (int)strtol(at, &at, 10);
    for (int i = 0; i < NUMBERS; i++)
        l->number[i] = strtod(at, &at);
    return 1;
}

/* Two NaNs are alike. */
static double difference(double a, double b) {
    if (isnan(a) && isnan(b)) return 0;
    double d = fabs(a - b);
    return isnan(d) ? INFINITY : d;
}

static void compare(const line *own, const line *other, const run_load *load, sums *s) {
    s->positions++;
    if (own->status == BTG_BUDGET || other->status == BTG_BUDGET) {
        s->cut_short++; /* where a search was cut short is no property of the part */
        return;
    }
    double height = difference(own->number[0], other->number[0]), pose = 0;
    for (int i = 1; i < NUMBERS; i++)
        pose = fmax(pose, difference(own->number[i], other->number[i]));
    s->same += own->status == other->status && height == 0 && pose == 0;
    s->height = fmax(s->height, height);
    s->pose = fmax(s->pose, pose);
    if (own->status == other->status && height <= LIMIT && pose <= LIMIT) return;
    s->bad++;
    fprintf(stderr, "%s with %s over (%a, %a): %s and %s, off by %g mm in height, %g in pose\n",
            load->part_name, load->tool_name, load->at.foot_x_mm, load->at.foot_y_mm,
            btg_status_name(own->status), btg_status_name(other->status), height, pose);
}

static int each(FILE *other, sums *s) {
    run_load load = {0};
    for (int n = 0; n < RUN_LOADS; n++) {
        run_load_open(&load, n);
        for (int i = 0; i < STEPS_PER_KIND * KINDS; i++) {
            run_load_prepare(&load, i % KINDS);
            if (run_load_step(&load, i % KINDS) < 0) return 0;
            line own = line_of(&load.at), want;
            if (!other) {
                print(&own);
                continue;
            }
            if (!read_line(other, &want)) return 0;
            compare(&own, &want, &load, s);
        }
    }
    run_load_close(&load);
    return 1;
}

int main(int argc, char **argv) {
    FILE *other = argc > 1 ? fopen(argv[1], "r") : NULL;
    sums s = {0};
    if (argc > 1 && !other) {
        fprintf(stderr, "cannot open %s\n", argv[1]);
        return 2;
    }
    if (!each(other, &s)) {
        fprintf(stderr, "an error, or too few positions to hold these against\n");
        return 1;
    }
    if (!other) return 0;
    printf("%d positions: %d the same to the bit, %d cut short, %d too far off; greatest "
           "differences %.2g mm in height, %.2g in tip, axis and tilt\n",
           s.positions, s.same, s.cut_short, s.bad, s.height, s.pose);
    return s.bad > 0;
}
