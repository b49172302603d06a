#include "io/shape.h"
#include "core/facets.h"

#include <stdlib.h>
#include <string.h>

/* Facets stray from the surface by this share of the part's size; by four times as much, so many
 * times over, where that would be too many of them. */
#define STRAY      1e-4
#define COARSER    6
#define SEGMENTS   64
#define ARC_STEPS  24
#define ROOM_FIRST 1024
/* ---- growing ------------------------------------------------------------------------------ */

static bool grow(void **list, size_t count, size_t more, size_t *room, size_t size) {
    size_t wanted = *room ? *room : ROOM_FIRST;
    while (wanted - count < more && wanted <= SIZE_MAX / 4)
        wanted *= 2;
    if (wanted - count < more || wanted > SIZE_MAX / size) return false;
    void *larger = realloc(*list, wanted * size);
    if (!larger) return false;
    *list = larger;
    *room = wanted;
    return true;
}

static bool make_room(btg_shape *s, size_t points, size_t indices) {
    bool ok = !s->short_of_memory && s->point_count + points <= UINT32_MAX;
    if (ok && s->point_room - s->point_count < points) {
        size_t room = s->point_room;
        ok = grow((void **)&s->normals, s->point_count, points, &room, 3 * sizeof(float)) &&
             grow((void **)&s->points, s->point_count, points, &s->point_room, 3 * sizeof(float));
    }
    if (ok && s->index_room - s->index_count < indices)
        ok = grow((void **)&s->indices, s->index_count, indices, &s->index_room, sizeof(uint32_t));
    if (!ok) s->short_of_memory = true;
    return ok;
}

static void add_point(btg_shape *s, btg_vec3 p, btg_vec3 n) {
    float *at = s->points + 3 * s->point_count, *normal = s->normals + 3 * s->point_count;
    at[0] = (float)p.x, at[1] = (float)p.y, at[2] = (float)p.z;
    normal[0] = (float)n.x, normal[1] = (float)n.y, normal[2] = (float)n.z;
    s->point_count++;
}

static void add_triangle(btg_shape *s, size_t a, size_t b, size_t c) {
    s->indices[s->index_count++] = (uint32_t)a;
    s->indices[s->index_count++] = (uint32_t)b;
    s->indices[s->index_count++] = (uint32_t)c;
}

void btg_shape_release(btg_shape *s) {
    free(s->points);
    free(s->normals);
    free(s->indices);
    *s = (btg_shape){0};
}

/* ---- parts -------------------------------------------------------------------------------- */

/* Faces that look away from a place well below the part are the outer ones: of a closed solid
 * their volume over any place is positive, of an open sheet that over a place below. */
static bool faces_inward(const btg_part *part, const btg_facets *f) {
    btg_vec3 low = part->info.box_min, high = part->info.box_max;
    btg_vec3 below =
        vec((low.x + high.x) / 2, (low.y + high.y) / 2, low.z - vec_norm(vec_sub(high, low)));
    double volume = 0;
    for (size_t t = 0; t < f->triangle_count; t++) {
        const uint32_t *c = f->triangles[t];
        btg_vec3 a = f->points[c[0]];
        btg_vec3 n = vec_cross(vec_sub(f->points[c[1]], a), vec_sub(f->points[c[2]], a));
        volume += vec_dot(vec_sub(a, below), n);
    }
    return volume < 0;
}

btg_status btg_shape_part(btg_shape *s, const btg_part *part, size_t most, btg_message *message) {
    btg_vec3 size = vec_sub(part->info.box_max, part->info.box_min);
    btg_facets_def def = {.chord_mm = STRAY * vec_norm(size), .triangles_max = most};
    btg_facets f;
    btg_status status = btg_facets_make(part, &def, &f, message);
    for (int i = 0; i < COARSER && status == BTG_ERROR_MEMORY; i++) {
        def.chord_mm *= 4;
        status = btg_facets_make(part, &def, &f, message);
    }
    if (status != BTG_OK) return status;
    bool turned = faces_inward(part, &f);
    if (make_room(s, f.vertex_count, 3 * f.triangle_count)) {
        size_t first = s->point_count;
        for (size_t i = 0; i < f.vertex_count; i++)
            add_point(s, f.points[i], turned ? vec_scale(f.normals[i], -1) : f.normals[i]);
        for (size_t t = 0; t < f.triangle_count; t++) {
            const uint32_t *c = f.triangles[t];
            add_triangle(s, first + c[0], first + c[turned ? 2 : 1], first + c[turned ? 1 : 2]);
        }
    }
    btg_facets_free(&f);
    if (!s->short_of_memory) return BTG_OK;
    return btg_fail(message, BTG_ERROR_MEMORY, "part: out of memory for its triangles");
}

/* ---- tools -------------------------------------------------------------------------------- */

/* A point of the outline: distance from the axis, height over the tip, and its normal. */
typedef struct outline {
    double r, z, nr, nz;
} outline;

static btg_status revolve(btg_shape *s, const outline *o, int count) {
    size_t first = s->point_count, row = SEGMENTS + 1;
    if (!make_room(s, (size_t)count * row, 6u * (size_t)(count - 1) * SEGMENTS))
        return BTG_ERROR_MEMORY;
    for (int i = 0; i < count; i++)
        for (int j = 0; j <= SEGMENTS; j++) {
            double turn = 2 * BTG_PI * (j % SEGMENTS) / SEGMENTS, c = cos(turn), sine = sin(turn);
            add_point(s, vec(o[i].r * c, o[i].r * sine, o[i].z),
                      vec(o[i].nr * c, o[i].nr * sine, o[i].nz));
        }
    for (int i = 0; i + 1 < count; i++) {
        bool edge = o[i].r == o[i + 1].r && o[i].z == o[i + 1].z; /* the normal turns alone */
        for (size_t j = 0; j < SEGMENTS && !edge; j++) {
            size_t a = first + (size_t)i * row + j, b = a + row;
            if (o[i].r > 0) add_triangle(s, a, a + 1, b + 1);
            if (o[i + 1].r > 0) add_triangle(s, a, b + 1, b);
        }
    }
    return BTG_OK;
}

/* From below the axis round the corner, heights over the tip. */
static btg_status add_cutter(btg_shape *s, const btg_tool_element *e) {
    outline o[ARC_STEPS + 5];
    int n = 0;
    double ring = e->ring_radius_mm, corner = e->corner_radius_mm, rim = ring + corner;
    double turn = e->hollow ? 2 * BTG_PI : BTG_PI / 2;
    if (!e->hollow && ring > 0) o[n++] = (outline){0, 0, 0, -1};
    for (int i = 0; i <= ARC_STEPS; i++) {
        double a = (e->hollow ? BTG_PI : 0) - BTG_PI / 2 + turn * i / ARC_STEPS;
        double r = fmax(ring + corner * cos(a), 0);
        o[n++] = (outline){r, corner + corner * sin(a), cos(a), sin(a)};
    }
    if (!e->hollow && corner > 0) {
        o[n++] = (outline){rim, corner, 0, 1};
        o[n++] = (outline){0, corner, 0, 1};
    }
    return revolve(s, o, n);
}

static btg_status add_cylinder(btg_shape *s, double radius, double from, double to) {
    const outline o[6] = {{0, from, 0, -1},   {radius, from, 0, -1}, {radius, from, 1, 0},
                          {radius, to, 1, 0}, {radius, to, 0, 1},    {0, to, 0, 1}};
    return revolve(s, o, 6);
}

btg_status btg_shape_tool(btg_shape *s, const btg_tool *tool, uint32_t index) {
    if (index >= tool->element_count) return BTG_ERROR_ARGUMENT;
    const btg_tool_element *e = &tool->element[index];
    if (index == 0) return add_cutter(s, e);
    double centre = tool->def.minor_radius_mm;
    return add_cylinder(s, e->ring_radius_mm, centre + e->from_mm, centre + e->to_mm);
}

btg_solid btg_shape_solid(const btg_tool *tool, uint32_t index) {
    if (index == 0) return BTG_SOLID_INSERT;
    return index == 1 && tool->def.shank.radius_mm > 0 ? BTG_SOLID_SHANK : BTG_SOLID_HOLDER;
}

btg_status btg_shape_rod(btg_shape *s, const btg_tool *tool, double length_mm) {
    const btg_tool_def *d = &tool->def;
    double rim = d->major_radius_mm + d->minor_radius_mm;
    /* Within the ring of a hollow cutter it begins a little over its centre; over a sharp one, that
     * is a disc, too. */
    double step = d->minor_radius_mm > 0 ? d->minor_radius_mm : 0.3 * rim;
    double from = d->minor_radius_mm + 0.25 * step, to = from + 0.5 * step;
    btg_status status = add_cylinder(s, 0.97 * fmax(d->major_radius_mm, 0.8 * rim), from, to);
    if (status != BTG_OK || length_mm <= 1.5 * rim) return status;
    return add_cylinder(s, 0.45 * rim, to, length_mm);
}

void btg_shape_mark(btg_shape *s, const float at[3], float radius_mm) {
    static const int face[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                   {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    size_t first = s->point_count;
    if (!make_room(s, 6, 24)) return;
    for (int i = 0; i < 6; i++) {
        btg_vec3 n = vec(0, 0, 0), p = vec(at[0], at[1], at[2]);
        double side = i % 2 ? -1 : 1;
        *(i / 2 == 0 ? &n.x : i / 2 == 1 ? &n.y : &n.z) = side;
        add_point(s, vec_mad(p, n, radius_mm), n);
    }
    for (int i = 0; i < 8; i++)
        add_triangle(s, first + (size_t)face[i][0], first + (size_t)face[i][1],
                     first + (size_t)face[i][2]);
}
