/* Does the placed tool cut the part? Answered without rays, search or derivatives: the definition
 * of the tool, dense samples of the part, and a pattern search downhill from the lowest. */
#include "conformance.h"
#include "core/part.h"

#include <stdlib.h>
#include <string.h>

/* Samples per size of the cutter; starts of the pattern search, that far apart in samples. */
#define SAMPLES_PER_SIZE 6
#define STARTS           8
#define APART            2.0

typedef struct sample {
    btg_vec3 s;
    btg_place place;
    double step_u, step_v;
} sample;

struct cloud {
    const btg_part *part;
    double spacing;
    sample *samples;
    size_t count, capacity;
};

double tool_clearance(const btg_tool *tool, btg_placement placement, btg_vec3 s) {
    btg_vec3 d = vec_sub(s, placement.centre);
    double z = vec_dot(d, placement.axis);
    double r = vec_norm(vec_mad(d, placement.axis, -z));
    const btg_tool_def *def = &tool->def;
    double across = r - def->major_radius_mm;
    double least = hypot(across, z) - def->minor_radius_mm;
    if (def->profile == BTG_PROFILE_BULLNOSE && across < 0) least = fabs(z) - def->minor_radius_mm;
    for (int i = -1; i < (int)def->holder_count; i++) {
        const btg_cylinder *c = i < 0 ? &def->shank : &def->holder[i];
        if (c->radius_mm == 0) continue;
        double out = r - c->radius_mm, off = fmax(c->from_mm - z, z - c->to_mm);
        double distance = out > 0 && off > 0 ? hypot(out, off) : fmax(out, off);
        least = fmin(least, distance);
    }
    return least;
}

static btg_vec3 point_of(const btg_part *part, btg_place place) {
    btg_surface_point p;
    btg_part_point(part, place, &p);
    return p.s;
}

static void add(cloud *c, btg_place place, double step_u, double step_v) {
    if (c->count == c->capacity) {
        c->capacity = 2 * c->capacity + 4096;
        c->samples = realloc(c->samples, c->capacity * sizeof *c->samples);
        if (!c->samples) abort();
    }
    c->samples[c->count++] = (sample){point_of(c->part, place), place, step_u, step_v};
}

static double polyline(const cloud *c, uint32_t item, bool along_u, double across) {
    double length = 0;
    btg_vec3 last = {0};
    for (int i = 0; i <= 20; i++) {
        double t = i / 20.0, side = item < c->part->patch_count ? across : across * (1 - t);
        btg_vec3 s = point_of(c->part, (btg_place){item, along_u ? t : side, along_u ? side : t});
        if (i > 0) length += vec_norm(vec_sub(s, last));
        last = s;
    }
    return length;
}

static int steps(const cloud *c, uint32_t item, bool along_u) {
    double length = 0;
    for (int i = 0; i <= 8; i++)
        length = fmax(length, polyline(c, item, along_u, i / 8.0));
    bool patch = item < c->part->patch_count;
    return (int)fmin(fmax(ceil(length / c->spacing), patch ? 12 : 2), 800);
}

cloud *cloud_make(const fixture *f) {
    cloud *c = calloc(1, sizeof *c);
    if (!c) abort();
    c->part = f->part;
    c->spacing = fixture_size(f) / SAMPLES_PER_SIZE;
    for (uint32_t item = 0; item < c->part->patch_count + c->part->triangle_count; item++) {
        bool patch = item < c->part->patch_count;
        int nu = steps(c, item, true), nv = steps(c, item, false);
        if (!patch) nu = nv = nu > nv ? nu : nv;
        for (int i = 0; i <= nu; i++)
            for (int j = 0; j <= (patch ? nv : nu - i); j++)
                add(c, (btg_place){item, (double)i / nu, (double)j / nv}, 1.0 / nu, 1.0 / nv);
    }
    return c;
}

void cloud_free(cloud *c) {
    if (!c) return;
    free(c->samples);
    free(c);
}

static btg_place hold(const btg_part *part, btg_place p) {
    p.u = fmin(fmax(p.u, 0), 1);
    p.v = fmin(fmax(p.v, 0), 1);
    if (p.item >= part->patch_count && p.u + p.v > 1) {
        double over = (p.u + p.v - 1) / 2;
        p.u = fmin(fmax(p.u - over, 0), 1);
        p.v = 1 - p.u;
    }
    return p;
}

/* Eight neighbours; the step halves where none is lower. */
static double descend(const cloud *c, const btg_tool *tool, btg_placement at, const sample *from) {
    btg_place best = from->place;
    double least = tool_clearance(tool, at, from->s), du = from->step_u, dv = from->step_v;
    for (int i = 0; i < 200 && (du > 1e-12 || dv > 1e-12); i++) {
        btg_place start = best;
        bool moved = false;
        for (int k = 0; k < 9; k++) {
            btg_place p = {start.item, start.u + (k % 3 - 1) * du, start.v + (k / 3 - 1) * dv};
            p = hold(c->part, p);
            double d = tool_clearance(tool, at, point_of(c->part, p));
            if (!(d < least)) continue;
            least = d;
            best = p;
            moved = true;
        }
        if (!moved) du /= 2, dv /= 2;
    }
    return least;
}

typedef struct starts {
    const sample *at[STARTS];
    double clearance[STARTS];
    int count;
} starts;

static void offer(starts *list, const cloud *c, const sample *s, double clearance) {
    int place = list->count;
    for (int i = 0; i < list->count; i++) {
        if (vec_norm(vec_sub(list->at[i]->s, s->s)) > APART * c->spacing) continue;
        if (list->clearance[i] <= clearance) return;
        place = i;
    }
    if (place == STARTS) {
        place = 0;
        for (int i = 1; i < STARTS; i++)
            if (list->clearance[i] > list->clearance[place]) place = i;
        if (list->clearance[place] <= clearance) return;
    }
    list->at[place] = s;
    list->clearance[place] = clearance;
    if (place == list->count) list->count++;
}

double cloud_clearance(const cloud *c, const fixture *f, btg_placement tool, const btg_vec3 *hint) {
    starts list = {.count = 0};
    double least = hint ? tool_clearance(&f->tool, tool, *hint) : INFINITY;
    for (size_t i = 0; i < c->count; i++) {
        const sample *s = &c->samples[i];
        double clearance = tool_clearance(&f->tool, tool, s->s);
        if (clearance < c->spacing) offer(&list, c, s, clearance);
    }
    for (int i = 0; i < list.count; i++)
        least = fmin(least, descend(c, &f->tool, tool, list.at[i]));
    return least;
}
