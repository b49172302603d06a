#include "backend/osmesa/view.h"
#include "core/part.h"

#include <string.h>

/* Pieces stand off their cell by less, in sizes of them. */
#define PIECE_MARGIN 0.01
/* Cosines between rays and normals are taken for no less, and levers, mm. */
#define STRAIGHT 0.05
/* A contact is farther off than its pixel where the normals differ by so many times what they would
 * beside it. */
#define AWAY 2

static btg_vec3 xyz(btg_gpu_vec4 a) {
    return vec(a.x, a.y, a.z);
}

static btg_vec3 into(const btg_view *view, btg_vec3 a) {
    return vec(vec_dot(a, view->u), vec_dot(a, view->v), vec_dot(a, view->w));
}

btg_view btg_view_make(const btg_scene *scene, const btg_gpu_query *query, uint32_t kind) {
    btg_view view = {.scene = scene, .query = query, .kind = kind};
    view.u = xyz(query->u);
    view.v = xyz(query->v);
    view.w = xyz(query->w);
    view.p = into(&view, xyz(query->p));
    view.n = into(&view, xyz(query->n));
    return view;
}

void btg_view_point(const btg_view *view, btg_vec3 point, double at[2]) {
    btg_vec3 s = vec_sub(point, xyz(view->query->origin));
    s = into(view, vec_sub(s, xyz(view->query->origin_low)));
    at[0] = s.x;
    if (view->kind == BTG_VIEW_PLANE)
        at[1] = s.y;
    else if (view->kind == BTG_VIEW_CYLINDER)
        at[1] = norm2(s.y, s.z);
    else
        at[1] = (s.y - view->p.y) * view->n.z - (s.z - view->p.z) * view->n.y;
}

/* All three views move a point by no more than it moves. */
static bool sees(const btg_view *view, const double window[4], btg_gpu_vec4 ball) {
    double at[2];
    btg_view_point(view, xyz(ball), at);
    return fabs(at[0] - window[0]) <= window[2] + ball.w &&
           fabs(at[1] - window[1]) <= window[3] + ball.w;
}

static void walk(const btg_view *view, const double window[4], uint32_t level, uint32_t node,
                 const btg_view_sink *sink) {
    btg_gpu_uvec4 here = view->scene->head.level[level];
    if (!sees(view, window, view->scene->geometry[here.x + node])) return;
    if (level == 0) {
        sink->take(sink->user, node);
        return;
    }
    uint32_t first = node * BTG_GPU_FAN, last = first + BTG_GPU_FAN;
    uint32_t count = view->scene->head.level[level - 1].y;
    if (last > count) last = count;
    for (uint32_t i = first; i < last; i++)
        walk(view, window, level - 1, i, sink);
}

void btg_view_cells(const btg_view *view, const double window[4], const btg_view_sink *sink) {
    walk(view, window, view->scene->head.counts.y - 1, 0, sink);
}

static const btg_gpu_vec4 *cell_at(const btg_scene *scene, uint32_t cell) {
    return scene->geometry + scene->head.starts.x + (size_t)BTG_GPU_CELL * cell;
}

double btg_view_radius(const btg_view *view, uint32_t cell) {
    return cell_at(view->scene, cell)[0].w;
}

/* The point (s, t) of a cell's quadratic piece, from the middle of the part. */
static btg_vec3 point_of(const btg_gpu_vec4 *c, double s, double t) {
    btg_vec3 p = vec_mad(vec_mad(vec_add(xyz(c[0]), xyz(c[1])), xyz(c[2]), s), xyz(c[3]), t);
    p = vec_mad(vec_mad(p, xyz(c[4]), 0.5 * s * s), xyz(c[5]), s * t);
    return vec_mad(p, xyz(c[6]), 0.5 * t * t);
}

/* How far a step goes in the image, at the most. */
static void reach(const btg_view *view, btg_vec3 step, double to[2]) {
    btg_vec3 s = into(view, step);
    to[0] += fabs(s.x);
    if (view->kind == BTG_VIEW_PLANE)
        to[1] += fabs(s.y);
    else if (view->kind == BTG_VIEW_CYLINDER)
        to[1] += norm2(s.y, s.z);
    else
        to[1] += fabs(s.y * view->n.z - s.z * view->n.y);
}

/* Half sides, in the image, of any piece of a cell: h of the cell's own. */
static void piece_sides(const btg_view *view, const btg_gpu_vec4 *c, double h, double sides[2]) {
    double bulge = vec_norm(xyz(c[4])) + 2 * vec_norm(xyz(c[5])) + vec_norm(xyz(c[6]));
    sides[0] = sides[1] = h * bulge + PIECE_MARGIN * c[0].w * h;
    reach(view, vec_scale(xyz(c[2]), h), sides);
    reach(view, vec_scale(xyz(c[3]), h), sides);
}

static void put(btg_gpu_vec4 *to, btg_vec3 a, double w) {
    *to = (btg_gpu_vec4){(float)a.x, (float)a.y, (float)a.z, (float)w};
}

static void fill_piece(const btg_scene *scene, const btg_part *part, btg_place at, double hu,
                       double hv, uint32_t cell, btg_gpu_vec4 piece[BTG_GPU_CELL]) {
    btg_surface_point c;
    btg_part_point(part, at, &c);
    btg_gpu_split(vec_sub(c.s, scene->middle), &piece[0], &piece[1]);
    piece[0].w = 0;
    piece[1].w = btg_gpu_bits(at.item);
    put(&piece[2], vec_scale(c.su, hu), at.u);
    put(&piece[3], vec_scale(c.sv, hv), at.v);
    put(&piece[4], vec_scale(c.suu, hu * hu), hu);
    put(&piece[5], vec_scale(c.suv, hu * hv), hv);
    put(&piece[6], vec_scale(c.svv, hv * hv), 0);
    piece[6].w = btg_gpu_bits(cell);
}

void btg_view_cut(const btg_view *view, const btg_part *part, const double window[4], uint32_t cell,
                  uint32_t cuts, const btg_view_pieces *sink) {
    const btg_gpu_vec4 *c = cell_at(view->scene, cell);
    double h = 1.0 / cuts, hu = c[4].w, hv = c[5].w, sides[2], middle[2];
    uint32_t item;
    piece_sides(view, c, h, sides);
    memcpy(&item, &c[1].w, sizeof item);
    bool triangle = item >= part->patch_count;
    for (uint32_t i = 0; i < cuts * cuts; i++) {
        double s = (2 * (i / cuts) + 1) * h - 1, t = (2 * (i % cuts) + 1) * h - 1;
        btg_place at = {item, c[2].w + s * hu, c[3].w + t * hv};
        if (triangle && at.u - h * hu + at.v - h * hv >= 1) continue;
        btg_view_point(view, point_of(c, s, t), middle);
        if (fabs(middle[0] - window[0]) > window[2] + sides[0]) continue;
        if (fabs(middle[1] - window[1]) > window[3] + sides[1]) continue;
        btg_gpu_vec4 piece[BTG_GPU_CELL];
        fill_piece(view->scene, part, at, h * hu, h * hv, cell, piece);
        sink->take(sink->user, piece);
    }
}

/* Half of what packSnorm2x16 makes. */
static double unpack(uint32_t half) {
    return max2(-1, (int16_t)(uint16_t)half / 32767.0);
}

btg_view_place btg_view_unpack(const btg_scene *scene, uint32_t cell, uint32_t packed) {
    const btg_gpu_vec4 *c = cell_at(scene, cell);
    double s = unpack(packed & 0xffff), t = unpack(packed >> 16);
    btg_view_place at = {.point = point_of(c, s, t)};
    memcpy(&at.item, &c[1].w, sizeof at.item);
    at.u = min2(max2(c[2].w + s * c[4].w, 0), 1);
    at.v = min2(max2(c[3].w + t * c[5].w, 0), 1);
    return at;
}

/* ---- what pixels hide --------------------------------------------------------------------- */

/* The part at a hit, in the query's frame: point, unit normal, greatest curvature about, and how
 * far the item's edge is. */
typedef struct sheet {
    btg_vec3 s, n;
    double curvature, edge;
} sheet;

static double to_edge(const btg_view *view, const btg_gpu_vec4 *c, double s, double t,
                      const double side[2]) {
    double u = c[2].w + s * c[4].w, v = c[3].w + t * c[5].w;
    double a = side[0] / c[4].w, b = side[1] / c[5].w;
    uint32_t item;
    memcpy(&item, &c[1].w, sizeof item);
    if (item >= view->scene->head.counts.x)
        return min2(min2(u * a, v * b), (1 - u - v) * min2(a, b));
    return min2(min2(u, 1 - u) * a, min2(v, 1 - v) * b);
}

static bool sheet_at(const btg_view *view, const btg_view_hit *hit, sheet *out) {
    const btg_gpu_vec4 *c = cell_at(view->scene, hit->cell);
    double s = unpack(hit->packed & 0xffff), t = unpack(hit->packed >> 16);
    btg_vec3 su = vec_mad(vec_mad(xyz(c[2]), xyz(c[4]), s), xyz(c[5]), t);
    btg_vec3 sv = vec_mad(vec_mad(xyz(c[3]), xyz(c[6]), t), xyz(c[5]), s);
    btg_vec3 n = vec_cross(su, sv), from = xyz(view->query->origin);
    double area = vec_norm(n), a = vec_norm(su), b = vec_norm(sv);
    if (!(area > 0)) return false;
    n = vec_scale(n, 1 / area);
    double bend = fabs(vec_dot(xyz(c[4]), n)) * b * b + fabs(vec_dot(xyz(c[6]), n)) * a * a +
                  2 * fabs(vec_dot(xyz(c[5]), n)) * a * b;
    from = vec_add(from, xyz(view->query->origin_low));
    *out = (sheet){into(view, vec_sub(point_of(c, s, t), from)), into(view, n),
                   bend / (area * area), to_edge(view, c, s, t, (const double[2]){a, b})};
    return true;
}

/* The cutter's normal at a point that it meets, in the frame as it stood before it turned. */
static btg_vec3 cutter_normal(const btg_view *view, double value, btg_vec3 s) {
    double major = view->scene->head.element[0].x, turned = 0;
    btg_vec3 centre = vec(0, 0, value);
    bool solid = view->scene->head.counts.w == 0;
    if (view->kind != BTG_VIEW_PLANE) {
        turned = -value;
        centre = vec(0, major, 0);
    }
    double c = cos(turned), k = sin(turned);
    btg_vec3 d = vec_sub(vec(s.x, c * s.y - k * s.z, k * s.y + c * s.z), centre);
    double r = norm2(d.x, d.y), out = solid && r < major ? 0 : r > 0 ? (r - major) / r : 0;
    btg_vec3 n = vec(d.x * out, d.y * out, d.z);
    n = vec(n.x, c * n.y + k * n.z, c * n.z - k * n.y);
    double length = vec_norm(n);
    return length > 0 ? vec_scale(n, 1 / length) : n;
}

double btg_view_hidden(const btg_view *view, const btg_view_hit *hit, double reach) {
    sheet p;
    if (!sheet_at(view, hit, &p)) return INFINITY;
    double minor = view->scene->head.element[0].y, lever = fabs(p.n.z), straight = lever;
    double curvature = p.curvature + (minor > 0 ? 1 / minor : 0);
    if (view->kind != BTG_VIEW_PLANE) {
        double radius = norm2(p.s.y, p.s.z);
        lever = fabs(p.s.y * p.n.z - p.s.z * p.n.y);
        straight = lever / radius;
        curvature += 1 / radius;
    }
    if (view->kind == BTG_VIEW_CONTACT) straight = fabs(vec_dot(p.n, view->n));
    double along = reach / max2(straight, STRAIGHT), slope = 1;
    bool round = hit->element == 0 && minor > 0;
    if (round) slope = vec_norm(vec_cross(p.n, cutter_normal(view, hit->value, p.s)));
    /* Inside a smooth face the normals differ by what the curvature turns them on the way to a
     * contact, or there is none so near; on an edge, of part or tool, they may by any angle. */
    if (round && slope > AWAY * curvature * along && p.edge > along) return 0;
    return slope * along / max2(lever, STRAIGHT);
}
