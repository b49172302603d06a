/* Tiles that are passed over: no cell of theirs would have been cut. Every cell, whatever the
 * cutter, against the lowest of the cutter's lower sides. */
#include "../conformance/rng.h"
#include "../unit/check.h"
#include "verify/internal.h"

#include <stdlib.h>
#include <string.h>

#define ROUNDS 64
#define STEPS  30
#define WIDE   61 /* cells: not a multiple of a tile's side */
#define HIGH   45
#define CELLS  (WIDE * HIGH)
#define TILES  (((WIDE + BTG_TILE - 1) / BTG_TILE) * ((HIGH + BTG_TILE - 1) / BTG_TILE))

static double part_z[CELLS], stock_z[CELLS], want[CELLS];
static float normal_z[CELLS];
static double tile_z[TILES], tile_x[TILES], tile_y[TILES];
static uint8_t stale[TILES];

static btg_field field_of(double cell) {
    btg_field f = {.width = WIDE,
                   .height = HIGH,
                   .x = -3,
                   .y = 11,
                   .cell = cell,
                   .top = 1000,
                   .bottom = 0,
                   .part_z = part_z,
                   .stock_z = stock_z,
                   .normal_z = normal_z};
    f.tiles.width = (WIDE + BTG_TILE - 1) / BTG_TILE;
    f.tiles.height = (HIGH + BTG_TILE - 1) / BTG_TILE;
    f.tiles.z = tile_z;
    f.tiles.along_x = tile_x;
    f.tiles.along_y = tile_y;
    f.tiles.stale = stale;
    memset(stale, 1, sizeof stale);
    return f;
}

/* The stock before: flat, or a wave that the cutter has much in common with. */
static void fill(const btg_field *f, rng *random, double size) {
    double lean_x = rng_range(random, -0.7, 0.7), lean_y = rng_range(random, -0.7, 0.7);
    double bend = rng_range(random, -0.6, 0.6) / size, rough = rng_range(random, 0, 0.02) * size;
    bool flat = rng_pick(random, 3) == 0;
    for (int i = 0; i < CELLS; i++) {
        double x = (i % WIDE - WIDE / 2) * f->cell, y = (i / WIDE - HIGH / 2) * f->cell;
        double z = 20 + lean_x * x + lean_y * y + bend * (x * x - 0.4 * y * y);
        z += rough * sin(13 * x / size) * cos(17 * y / size);
        stock_z[i] = want[i] = flat ? 20 : z;
        part_z[i] = -INFINITY;
        normal_z[i] = 1;
    }
}

static btg_step step_of(const btg_field *f, const btg_cutter *c, rng *random) {
    double size = c->major + c->minor, lean = rng_range(random, 0, 1) * rng_range(random, 0, 1.45);
    double round = rng_range(random, 0, 7);
    btg_step s = {.axis = {sin(lean) * cos(round), sin(lean) * sin(round), cos(lean)}};
    s.centre.x = f->x + f->cell * rng_range(random, -10, WIDE + 10);
    s.centre.y = f->y + f->cell * rng_range(random, -10, HIGH + 10);
    /* Often it just touches. */
    double low = INFINITY;
    for (int i = 0; i < CELLS; i++) {
        double z, x = f->x + (i % WIDE) * f->cell - s.centre.x;
        double y = f->y + (i / WIDE) * f->cell - s.centre.y;
        if (btg_cutter_under(c, s.axis, x, y, &z)) low = fmin(low, z - want[i]);
    }
    if (!isfinite(low)) low = -20;
    s.centre.z = -low - 0.01 * size * rng_range(random, 0, 1) * rng_pick(random, 4);
    return s;
}

static void cut_all(const btg_field *f, const btg_cutter *c, const btg_step *s) {
    for (int i = 0; i < CELLS; i++) {
        double z, x = f->x + (i % WIDE) * f->cell - s->centre.x;
        double y = f->y + (i / WIDE) * f->cell - s->centre.y;
        if (btg_cutter_under(c, s->axis, x, y, &z)) want[i] = fmin(want[i], z + s->centre.z);
    }
}

int main(void) {
    rng random = rng_of(5, "tiles", 0);
    double worst = 0;
    long passed = 0, asked = 0;
    int rounds = getenv("BTG_TEST_QUICK") ? ROUNDS / 4 : ROUNDS;
    for (int round = 0; round < rounds; round++) {
        bool hollow = round % 2 != 0;
        btg_cutter c = {rng_range(&random, 0.2, 8), rng_range(&random, 0.3, 6), hollow};
        if (round % 16 == 0) c.major = 0;
        if (round % 16 == 2) c.minor = 0;
        if (round % 16 == 5) c.major = c.minor;
        btg_field f = field_of((c.major + c.minor) / rng_range(&random, 8, 120));
        fill(&f, &random, c.major + c.minor);
        for (int i = 0; i < STEPS; i++) {
            btg_step s = step_of(&f, &c, &random);
            double room[TILES];
            for (uint32_t row = 0; row < f.tiles.height; row++) {
                btg_tiles_refresh(&f, row, 0, f.tiles.width);
                btg_tiles_measure(&f, &c, s.centre, s.axis, row, 0, f.tiles.width, room);
                for (uint32_t k = 0; k < f.tiles.width; k++, asked++)
                    passed += room[k] < 0;
            }
            btg_band bands[2] = {{.gouge = 0}};
            btg_stock_cut(&f, &c, &s, 1, 0, BTG_BAND_ROWS, &bands[0]);
            btg_stock_cut(&f, &c, &s, 1, BTG_BAND_ROWS, HIGH, &bands[1]);
            cut_all(&f, &c, &s);
        }
        for (int i = 0; i < CELLS; i++)
            worst = fmax(worst, fabs(stock_z[i] - want[i]));
    }
    printf("%ld of %ld tiles passed over; cells within %.3g mm\n", passed, asked, worst);
    CHECK(worst < 1e-8);
    CHECK(passed > asked / 2);
    return check_result();
}
