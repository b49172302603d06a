#include "core/facets.h"

/* Places a side that a patch's second derivatives are looked at. */
#define PROBES 9
/* A curved patch's normals are to look smooth whatever the chord. */
#define SIDE_MIN 4
/* A derivative of less than this share of the part's size is rounding. */
#define NOTHING 1e-9

static double probe(int i) {
    return i / (PROBES - 1.0);
}

/* Cells along u and v. A cell of sides hu, hv leaves its bilinear net by at most
 * (|Suu| hu^2 + 2 |Suv| hu hv + |Svv| hv^2) / 8; every term gets its share of the chord. */
static void cells_of(const btg_part *part, uint32_t item, double chord, uint32_t cells[2]) {
    double uu = 0, uv = 0, vv = 0;
    for (int i = 0; i < PROBES; i++)
        for (int k = 0; k < PROBES; k++) {
            btg_surface_point s;
            btg_part_point(part, (btg_place){item, probe(i), probe(k)}, &s);
            uu = max2(uu, vec_norm(s.suu));
            uv = max2(uv, vec_norm(s.suv));
            vv = max2(vv, vec_norm(s.svv));
        }
    double second[2] = {uu, vv};
    double plane = NOTHING * part->scale;
    bool flat = uu <= plane && uv <= plane && vv <= plane;
    for (int d = 0; d < 2; d++) {
        double n = ceil(sqrt(max2(second[d], uv) * 4 / (8 * chord)));
        double least = flat ? 1 : SIDE_MIN;
        cells[d] = n < least ? (uint32_t)least
                             : (n < BTG_FACETS_SIDE_MAX ? (uint32_t)n : BTG_FACETS_SIDE_MAX);
    }
}

/* The surface's normal; zero where its derivatives give none. */
static btg_vec3 normal_of(const btg_part *part, const btg_surface_point *s) {
    btg_vec3 n = vec_cross(s->su, s->sv);
    double sine = vec_norm(n), u = vec_norm(s->su), v = vec_norm(s->sv);
    bool side = min2(u, v) > NOTHING * part->scale;
    return side && sine > NOTHING * u * v ? vec_scale(n, 1 / sine) : vec(0, 0, 0);
}

static void add_triangle(btg_facets *f, size_t a, size_t b, size_t c) {
    uint32_t *corner = f->triangles[f->triangle_count++];
    corner[0] = (uint32_t)a;
    corner[1] = (uint32_t)b;
    corner[2] = (uint32_t)c;
}

static btg_vec3 face(const btg_facets *f, const uint32_t corner[3]) {
    btg_vec3 a = f->points[corner[0]];
    return vec_cross(vec_sub(f->points[corner[1]], a), vec_sub(f->points[corner[2]], a));
}

/* Vertices whose surface has no normal take the sum of the faces about them. */
static void mend_normals(btg_facets *f, size_t first_vertex, size_t first_triangle) {
    for (size_t i = first_vertex; i < f->vertex_count; i++) {
        if (vec_norm2(f->normals[i]) > 0) continue;
        btg_vec3 sum = vec(0, 0, 0);
        for (size_t t = first_triangle; t < f->triangle_count; t++)
            for (int k = 0; k < 3; k++)
                if (f->triangles[t][k] == i) sum = vec_add(sum, face(f, f->triangles[t]));
        f->normals[i] = vec_norm2(sum) > 0 ? vec_unit(sum) : vec(0, 0, 1);
    }
}

static void add_patch(btg_facets *f, const btg_part *part, uint32_t item, const uint32_t cells[2]) {
    size_t vertex = f->vertex_count, triangle = f->triangle_count, row = (size_t)cells[1] + 1;
    bool mend = false;
    for (uint32_t i = 0; i <= cells[0]; i++)
        for (uint32_t k = 0; k <= cells[1]; k++) {
            btg_surface_point s;
            btg_place place = {item, (double)i / cells[0], (double)k / cells[1]};
            btg_part_point(part, place, &s);
            size_t at = f->vertex_count++;
            f->points[at] = s.s;
            f->normals[at] = normal_of(part, &s);
            mend = mend || !(vec_norm2(f->normals[at]) > 0);
            if (i == 0 || k == 0) continue;
            add_triangle(f, at - row - 1, at - 1, at);
            add_triangle(f, at - row - 1, at, at - row);
        }
    if (mend) mend_normals(f, vertex, triangle);
}

static void add_face(btg_facets *f, const btg_part *part, uint32_t triangle) {
    btg_vec3 corner[3];
    size_t first = f->vertex_count;
    btg_triangle_corners(part, triangle, corner);
    for (int k = 0; k < 3; k++)
        f->points[f->vertex_count++] = corner[k];
    add_triangle(f, first, first + 1, first + 2);
    btg_vec3 n = vec_unit(face(f, f->triangles[f->triangle_count - 1]));
    if (!(vec_norm2(n) > 0)) n = vec(0, 0, 1);
    for (int k = 0; k < 3; k++)
        f->normals[first + (size_t)k] = n;
}

static bool room(btg_facets *f, const btg_allocator *allocator, size_t vertices, size_t triangles) {
    *f = (btg_facets){.allocator = *allocator};
    f->points = btg_allocate(allocator, vertices, sizeof *f->points);
    f->normals = btg_allocate(allocator, vertices, sizeof *f->normals);
    f->triangles = btg_allocate(allocator, triangles, sizeof *f->triangles);
    if (f->points && f->normals && f->triangles) return true;
    btg_facets_free(f);
    return false;
}

btg_status btg_facets_make(const btg_part *part, const btg_facets_def *def, btg_facets *facets,
                           btg_message *message) {
    if (!(def->chord_mm > 0 && isfinite(def->chord_mm)))
        return btg_fail(message, BTG_ERROR_ARGUMENT, "facets: the chord is not above 0 mm");
    size_t triangles = part->triangle_count, vertices = 3 * triangles;
    for (uint32_t i = 0; i < part->patch_count; i++) {
        uint32_t cells[2];
        cells_of(part, i, def->chord_mm, cells);
        vertices += ((size_t)cells[0] + 1) * ((size_t)cells[1] + 1);
        triangles += 2 * (size_t)cells[0] * cells[1];
    }
    if (vertices > UINT32_MAX || (def->triangles_max && triangles > def->triangles_max))
        return btg_fail(message, BTG_ERROR_MEMORY,
                        "facets: the part needs %zu triangles; choose a longer chord", triangles);
    btg_facets f;
    if (!room(&f, &def->allocator, vertices, triangles))
        return btg_fail(message, BTG_ERROR_MEMORY,
                        "facets: out of memory for %zu triangles; choose a longer chord",
                        triangles);
    for (uint32_t i = 0; i < part->patch_count; i++) {
        uint32_t cells[2];
        cells_of(part, i, def->chord_mm, cells);
        add_patch(&f, part, i, cells);
    }
    for (uint32_t i = 0; i < part->triangle_count; i++)
        add_face(&f, part, i);
    *facets = f;
    return BTG_OK;
}

void btg_facets_free(btg_facets *facets) {
    btg_release(&facets->allocator, facets->points);
    btg_release(&facets->allocator, facets->normals);
    btg_release(&facets->allocator, facets->triangles);
    *facets = (btg_facets){0};
}
