/* The part: its surfaces as Bezier patches, its triangles, and the trees over both. */
#include "core/part.h"
#include "core/block.h"
#include "core/mesh.h"
#include "core/surface.h"
#include "core/tree.h"

#include <string.h>

/* Patches of one part: their number times the largest net must stay countable in 32 bits. */
#define PATCHES_MAX 10000000u

btg_part_def btg_part_def_default(void) {
    return (btg_part_def){.version = 1};
}

/* ---- counting and checking ---------------------------------------------------------------- */

typedef struct part_size {
    size_t patches, coefficients, vertices, triangles;
    double scale;
} part_size;

static double largest(const double *x, size_t count, double most) {
    for (size_t i = 0; i < count; i++)
        if (fabs(x[i]) > most) most = fabs(x[i]);
    return most;
}

static btg_status check_surfaces(const btg_part_def *def, part_size *size, btg_message *message) {
    for (size_t i = 0; i < def->surface_count; i++) {
        const btg_surface_def *s = &def->surfaces[i];
        btg_status status = btg_surface_check(s, i, message);
        if (status) return status;
        size_t patches = btg_surface_patch_count(s);
        size_t net = (size_t)(s->degree_u + 1) * (size_t)(s->degree_v + 1) * 4;
        size->patches += patches;
        size->coefficients += patches * net;
        if (size->patches > PATCHES_MAX)
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "surface %zu: more than %u Bezier patches in one part; split the part",
                            i, PATCHES_MAX);
        size->scale =
            largest(s->control_points, 3 * (size_t)s->count_u * (size_t)s->count_v, size->scale);
    }
    return BTG_OK;
}

static btg_status check_meshes(const btg_part_def *def, part_size *size, btg_message *message) {
    for (size_t i = 0; i < def->mesh_count; i++) {
        const btg_mesh_def *m = &def->meshes[i];
        btg_status status = btg_mesh_check(m, i, message);
        if (status) return status;
        size->vertices += m->vertex_count;
        size->triangles += m->triangle_count;
        if (size->vertices > UINT32_MAX || size->triangles > BTG_TRIANGLES_MAX)
            return btg_fail(message, BTG_ERROR_ARGUMENT,
                            "mesh %zu: more than %u triangles in one part; split the part", i,
                            BTG_TRIANGLES_MAX);
        size->scale = largest(m->positions, 3 * m->vertex_count, size->scale);
    }
    return BTG_OK;
}

static btg_status check_part(const btg_part_def *def, part_size *size, btg_message *message) {
    if (def->version != 1)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "part: version %u is unknown; start from btg_part_def_default",
                        def->version);
    if (!def->allocator.allocate != !def->allocator.release)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "part: allocator has one hook of two; give both or none");
    if ((def->surface_count && !def->surfaces) || (def->mesh_count && !def->meshes))
        return btg_fail(message, BTG_ERROR_ARGUMENT, "part: an array is NULL, its count is not 0");
    btg_status status = check_surfaces(def, size, message);
    if (!status) status = check_meshes(def, size, message);
    if (status) return status;
    if (size->patches + size->triangles == 0)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "part: no surface and no triangle; give at least one");
    return BTG_OK;
}

/* ---- filling ------------------------------------------------------------------------------ */

typedef struct patch_fill {
    btg_part *part;
    btg_quarters_list list;
    size_t coefficient_at;
    uint32_t surface;
    bool rational;
} patch_fill;

static btg_status add_patch(const btg_net *net, const double domain_u[2], const double domain_v[2],
                            void *user) {
    patch_fill *fill = user;
    btg_part *part = fill->part;
    uint32_t index = part->patch_count;
    btg_patch *patch = &part->patches[index];
    double *out = part->coefficients + fill->coefficient_at;
    size_t count = 4 * (size_t)(net->degree_u + 1) * (size_t)(net->degree_v + 1);
    memcpy(out, net->point, count * sizeof *out);
    fill->coefficient_at += 2 * count;
    *patch = (btg_patch){.coefficients = out,
                         .power = out + count,
                         .rational = fill->rational,
                         .surface = fill->surface};
    patch->degree_u = (uint8_t)net->degree_u;
    patch->degree_v = (uint8_t)net->degree_v;
    memcpy(patch->domain_u, domain_u, sizeof patch->domain_u);
    memcpy(patch->domain_v, domain_v, sizeof patch->domain_v);
    patch->origin = btg_patch_point(patch, 0.5, 0.5);
    patch->rounding = btg_net_power(net, patch->origin, out + count);
    part->patch_count++;
    return btg_tree_add_patch(part, net, index, &fill->list, &part->quarters_depth);
}

static btg_status fill_patches(btg_part *part, const btg_part_def *def) {
    patch_fill fill = {.part = part};
    btg_status status = BTG_OK;
    for (size_t i = 0; i < def->surface_count && !status; i++) {
        fill.surface = (uint32_t)i;
        fill.rational = def->surfaces[i].weights != NULL;
        status = btg_surface_cut(&def->surfaces[i], add_patch, &fill);
    }
    part->quarters = fill.list.at;
    part->quarters_count = fill.list.count;
    part->info.memory_bytes += fill.list.capacity * sizeof *part->quarters;
    return status;
}

static void fill_meshes(btg_part *part, const btg_part_def *def) {
    size_t vertex_at = 0, triangle_at = 0;
    for (size_t i = 0; i < def->mesh_count; i++) {
        btg_mesh_append(part, &def->meshes[i], vertex_at, triangle_at);
        vertex_at += def->meshes[i].vertex_count;
        triangle_at += def->meshes[i].triangle_count;
    }
    part->triangle_count = (uint32_t)triangle_at;
}

static btg_status allocate_arrays(btg_part *part, const part_size *size) {
    const btg_allocator *a = &part->allocator;
    part->patches = btg_allocate(a, size->patches, sizeof *part->patches);
    part->coefficients = btg_allocate(a, size->coefficients, 2 * sizeof *part->coefficients);
    part->vertices = btg_allocate(a, size->vertices, sizeof *part->vertices);
    part->triangles = btg_allocate(a, size->triangles, sizeof *part->triangles);
    part->info.memory_bytes = sizeof *part + size->patches * sizeof *part->patches +
                              2 * size->coefficients * sizeof *part->coefficients +
                              size->vertices * sizeof *part->vertices +
                              size->triangles * sizeof *part->triangles;
    bool patches = part->patches && part->coefficients;
    bool triangles = part->vertices && part->triangles;
    return (patches || !size->patches) && (triangles || !size->triangles) ? BTG_OK
                                                                          : BTG_ERROR_MEMORY;
}

/* ---- extent ------------------------------------------------------------------------------- */

/* A patch's net seen along a direction: w (direction . point) and w, v fastest. */
typedef struct profile {
    int n, m;
    double at[BTG_ORDER_MAX * BTG_ORDER_MAX][2];
} profile;

/* De Casteljau at 1/2 on count + 1 entries `stride` apart, from `first` on. */
static void halve_line(profile *low, profile *high, int first, int count, int stride) {
    for (int c = 0; c < 2; c++)
        for (int k = 0; k <= count; k++) {
            high->at[first + (count - k) * stride][c] = low->at[first + count * stride][c];
            for (int i = count; i > k; i--) {
                double *p = &low->at[first + i * stride][c];
                *p = 0.5 * (*p + low->at[first + (i - 1) * stride][c]);
            }
        }
}

static void halve_profile(const profile *of, bool along_u, profile *low, profile *high) {
    *low = *high = *of;
    if (along_u)
        for (int j = 0; j <= of->m; j++)
            halve_line(low, high, j, of->n, of->m + 1);
    else
        for (int i = 0; i <= of->n; i++)
            halve_line(low, high, i * (of->m + 1), of->m, 1);
}

/* The largest height of a profile, or `best` when that is more; to `tolerance`: a patch lies below
 * its highest control point and passes through its corners. */
static double profile_extent(const profile *p, int depth, double tolerance, double best) {
    enum { DEPTH_MAX = 44 };
    double most = -INFINITY;
    int last = p->n * (p->m + 1);
    const int corner[4] = {0, p->m, last, last + p->m};
    for (int i = 0; i < (p->n + 1) * (p->m + 1); i++)
        most = fmax(most, p->at[i][0] / p->at[i][1]);
    for (int i = 0; i < 4; i++)
        best = fmax(best, p->at[corner[i]][0] / p->at[corner[i]][1]);
    if (most <= best + tolerance || depth == DEPTH_MAX) return best;
    profile low, high;
    halve_profile(p, depth % 2 == 0, &low, &high);
    best = profile_extent(&low, depth + 1, tolerance, best);
    return profile_extent(&high, depth + 1, tolerance, best);
}

static double patch_extent(const btg_patch *patch, btg_vec3 direction, double tolerance,
                           double best) {
    profile p = {.n = patch->degree_u, .m = patch->degree_v};
    for (int i = 0; i < (p.n + 1) * (p.m + 1); i++) {
        const double *c = patch->coefficients + 4 * i;
        p.at[i][0] = vec_dot(vec(c[0], c[1], c[2]), direction);
        p.at[i][1] = c[3];
    }
    return profile_extent(&p, 0, tolerance, best);
}

/* The largest direction . s over all patches. */
static double extent(const btg_part *part, btg_vec3 direction) {
    double best = -INFINITY;
    btg_surface_point s;
    for (uint32_t i = 0; i < part->patch_count; i++)
        for (int corner = 0; corner < 4; corner++) {
            btg_part_point(part, (btg_place){i, corner & 1, corner >> 1}, &s);
            best = fmax(best, vec_dot(s.s, direction));
        }
    for (uint32_t i = 0; i < part->patch_count; i++)
        best = patch_extent(&part->patches[i], direction, 1e-6 * part->scale, best);
    return best;
}

static void add_triangles(const btg_part *part, btg_vec3 *low, btg_vec3 *high) {
    for (uint32_t i = 0; i < part->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            btg_vec3 p = part->vertices[part->triangles[i][k]];
            *low = vec(min2(p.x, low->x), min2(p.y, low->y), min2(p.z, low->z));
            *high = vec(max2(p.x, high->x), max2(p.y, high->y), max2(p.z, high->z));
        }
}

static void fill_info(btg_part *part, const btg_part_def *def) {
    btg_part_info *info = &part->info;
    info->surface_count = def->surface_count;
    info->patch_count = part->patch_count;
    info->triangle_count = part->triangle_count;
    info->memory_bytes += part->piece_count * sizeof *part->pieces +
                          part->triangle_count * sizeof *part->order +
                          part->node_count * sizeof *part->nodes;
    btg_vec3 high =
        vec(extent(part, vec(1, 0, 0)), extent(part, vec(0, 1, 0)), extent(part, vec(0, 0, 1)));
    btg_vec3 low = vec(0 - extent(part, vec(-1, 0, 0)), 0 - extent(part, vec(0, -1, 0)),
                       0 - extent(part, vec(0, 0, -1))); /* no -0 */
    add_triangles(part, &low, &high);
    info->box_min = vec(0 + low.x, 0 + low.y, 0 + low.z);
    info->box_max = high;
}

/* ---- public ------------------------------------------------------------------------------- */

btg_status btg_part_create(const btg_part_def *def, btg_part **out, btg_message *message) {
    if (!def || !out) return btg_fail(message, BTG_ERROR_ARGUMENT, "part: def or part is NULL");
    part_size size = {.scale = 1};
    btg_status status = check_part(def, &size, message);
    if (status) return status;
    btg_part *part = btg_allocate(&def->allocator, 1, sizeof *part);
    if (part) {
        memset(part, 0, sizeof *part);
        part->allocator = def->allocator;
        part->scale = size.scale;
        status = allocate_arrays(part, &size);
        if (!status) status = fill_patches(part, def);
        if (!status) {
            fill_meshes(part, def);
            status = btg_tree_build(part);
        }
    }
    if (!part || status) {
        btg_part_destroy(part);
        return btg_fail(message, BTG_ERROR_MEMORY,
                        "part: no memory for %zu patches and %zu triangles; split the part",
                        size.patches, size.triangles);
    }
    fill_info(part, def);
    *out = part;
    return BTG_OK;
}

void btg_part_destroy(btg_part *part) {
    if (!part) return;
    btg_allocator a = part->allocator;
    void *memory[] = {part->patches,  part->coefficients, part->quarters, part->pieces,
                      part->vertices, part->triangles,    part->nodes,    part->order};
    for (size_t i = 0; i < sizeof memory / sizeof *memory; i++)
        btg_release(&a, memory[i]);
    btg_release(&a, part);
}

void btg_part_get_info(const btg_part *part, btg_part_info *info) {
    *info = part->info;
}

btg_status btg_part_evaluate(const btg_part *part, btg_place place, btg_surface_point *point) {
    if (!part || !point) return BTG_ERROR_ARGUMENT;
    size_t items = (size_t)part->patch_count + part->triangle_count;
    bool inside = place.u >= 0 && place.v >= 0 && place.u <= 1 && place.v <= 1;
    if (place.item >= part->patch_count && !(place.u + place.v <= 1 + 1e-12)) inside = false;
    if (place.item >= items || !inside) return BTG_ERROR_ARGUMENT;
    btg_part_point(part, place, point);
    return BTG_OK;
}
