#include "io/relief.h"

#include <math.h>
#include <stdlib.h>

/* A patch is drawn in cells of about this many pixels, at most CELLS_MAX by CELLS_MAX of them:
 * small enough that neither its outline nor its shading shows corners. */
#define CELL_PIXELS 3.0
#define CELLS_MAX   512
#define CELLS_PROBE 6 /* the grid that measures how large a patch is on the picture */

/* From the upper left, as maps are lit; slopes are drawn steeper than they are, to be seen. */
static const double light_from[3] = {-0.48, 0.56, 0.676};
#define STEEPEN 1.5

typedef struct corner {
    double x, y; /* pixels */
    double z, light;
    int flat; /* no normal here: take the cell's */
} corner;

static double light_of(double nx, double ny, double nz) {
    nx *= STEEPEN, ny *= STEEPEN;
    double length = sqrt(nx * nx + ny * ny + nz * nz);
    if (!(length > 0)) return -1;
    double facing = nz < 0 ? -1 : 1; /* the side the tool sees */
    double cosine =
        facing * (nx * light_from[0] + ny * light_from[1] + nz * light_from[2]) / length;
    return cosine > 0 ? cosine : 0;
}

static int corner_at(const btg_relief *relief, const btg_part *part, uint32_t item, double u,
                     double v, corner *c) {
    btg_surface_point p;
    btg_place place = {item, u, v};
    if (btg_part_evaluate(part, place, &p) < 0) return 0;
    c->x = (p.s.x - relief->x_min_mm) / relief->mm_per_pixel;
    c->y = (relief->y_max_mm - p.s.y) / relief->mm_per_pixel;
    c->z = p.s.z;
    c->light = light_of(p.su.y * p.sv.z - p.su.z * p.sv.y, p.su.z * p.sv.x - p.su.x * p.sv.z,
                        p.su.x * p.sv.y - p.su.y * p.sv.x);
    c->flat = c->light < 0;
    return 1;
}

static double face_light(const btg_relief *relief, const corner *a, const corner *b,
                         const corner *c) {
    double s = relief->mm_per_pixel;
    double bx = (b->x - a->x) * s, by = -(b->y - a->y) * s, bz = b->z - a->z;
    double cx = (c->x - a->x) * s, cy = -(c->y - a->y) * s, cz = c->z - a->z;
    double light = light_of(by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx);
    return light < 0 ? 0.5 : light;
}

static int clamp_pixel(double at, int size) {
    return at < 0 ? 0 : at > size - 1 ? size - 1 : (int)at;
}

/* The highest wins, pixel by pixel (pixel centres; an edge belongs to both sides). */
static void draw_triangle(btg_relief *relief, const corner *a, const corner *b, const corner *c) {
    double area = (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
    if (!(fabs(area) > 1e-12)) return; /* seen edge-on */
    double flat = a->flat || b->flat || c->flat ? face_light(relief, a, b, c) : 0;
    double la = a->flat ? flat : a->light;
    double lb = b->flat ? flat : b->light;
    double lc = c->flat ? flat : c->light;
    int x0 = clamp_pixel(fmin(a->x, fmin(b->x, c->x)) - 0.5, relief->width);
    int x1 = clamp_pixel(fmax(a->x, fmax(b->x, c->x)) + 0.5, relief->width);
    int y0 = clamp_pixel(fmin(a->y, fmin(b->y, c->y)) - 0.5, relief->height);
    int y1 = clamp_pixel(fmax(a->y, fmax(b->y, c->y)) + 0.5, relief->height);
    for (int row = y0; row <= y1; row++) {
        for (int column = x0; column <= x1; column++) {
            double px = column + 0.5, py = row + 0.5;
            double wb = ((px - a->x) * (c->y - a->y) - (py - a->y) * (c->x - a->x)) / area;
            double wc = ((b->x - a->x) * (py - a->y) - (b->y - a->y) * (px - a->x)) / area;
            double wa = 1 - wb - wc;
            if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
            size_t at = (size_t)row * (size_t)relief->width + (size_t)column;
            float z = (float)(wa * a->z + wb * b->z + wc * c->z);
            if (z > relief->z_mm[at]) {
                relief->z_mm[at] = z;
                relief->light[at] = (float)(wa * la + wb * lb + wc * lc);
            }
        }
    }
}

static void draw_face(btg_relief *relief, const btg_part *part, uint32_t item) {
    corner c[3];
    if (!corner_at(relief, part, item, 0, 0, &c[0]) ||
        !corner_at(relief, part, item, 1, 0, &c[1]) || !corner_at(relief, part, item, 0, 1, &c[2]))
        return;
    draw_triangle(relief, &c[0], &c[1], &c[2]);
}

/* Cells along u and along v that give CELL_PIXELS, from the longest lines of a coarse grid. */
static void cells_of(const btg_relief *relief, const btg_part *part, uint32_t item, int cells[2]) {
    for (int direction = 0; direction < 2; direction++) {
        double longest = 0;
        for (int i = 0; i <= CELLS_PROBE; i++) {
            double length = 0;
            corner before = {0}, now = {0};
            for (int j = 0; j <= CELLS_PROBE; j++) {
                double s = (double)i / CELLS_PROBE, t = (double)j / CELLS_PROBE;
                if (!corner_at(relief, part, item, direction ? s : t, direction ? t : s, &now))
                    continue;
                if (j > 0) length += hypot(now.x - before.x, now.y - before.y);
                before = now;
            }
            longest = fmax(longest, length);
        }
        double wanted = ceil(longest / CELL_PIXELS) + 1;
        cells[direction] = wanted < CELLS_MAX ? (int)wanted : CELLS_MAX;
    }
}

/* Two rows of corners at a time. */
static void draw_patch(btg_relief *relief, const btg_part *part, uint32_t item, corner *rows) {
    int cells[2];
    cells_of(relief, part, item, cells);
    corner *before = rows, *now = rows + CELLS_MAX + 1;
    for (int i = 0; i <= cells[0]; i++) {
        for (int j = 0; j <= cells[1]; j++) {
            if (!corner_at(relief, part, item, (double)i / cells[0], (double)j / cells[1], &now[j]))
                return;
            if (i == 0 || j == 0) continue;
            draw_triangle(relief, &before[j - 1], &before[j], &now[j]);
            draw_triangle(relief, &before[j - 1], &now[j], &now[j - 1]);
        }
        corner *swap = before;
        before = now;
        now = swap;
    }
}

btg_status btg_relief_render(btg_relief *relief, const btg_part *part) {
    if (relief->width < 1 || relief->height < 1) return BTG_ERROR_ARGUMENT;
    size_t pixels = (size_t)relief->width * (size_t)relief->height;
    relief->z_mm = malloc(pixels * sizeof *relief->z_mm);
    relief->light = calloc(pixels, sizeof *relief->light);
    corner *rows = malloc(2 * (CELLS_MAX + 1) * sizeof *rows);
    if (!relief->z_mm || !relief->light || !rows) {
        free(rows);
        btg_relief_release(relief);
        return BTG_ERROR_MEMORY;
    }
    for (size_t i = 0; i < pixels; i++)
        relief->z_mm[i] = -INFINITY;

    btg_part_info info;
    btg_part_get_info(part, &info);
    size_t items = info.patch_count + info.triangle_count;
    for (size_t item = 0; item < items; item++) {
        if (item < info.patch_count)
            draw_patch(relief, part, (uint32_t)item, rows);
        else
            draw_face(relief, part, (uint32_t)item);
    }
    free(rows);
    return BTG_OK;
}

void btg_relief_release(btg_relief *relief) {
    free(relief->z_mm);
    free(relief->light);
    relief->z_mm = NULL;
    relief->light = NULL;
}
