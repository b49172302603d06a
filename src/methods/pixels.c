/* DROP by a depth image without a rasteriser: one ray a pixel, along the tool's axis. M. Singh, S.
 * Bedi, S. Mann, "A GPU Method and Error Analysis of Multi-Point Positioning of a Toroidal Tool for
 * 5-Axis Machining", 2024, sections 5 to 7: the window is as wide as the tool; the pixel at which
 * part and tool are nearest is where they touch, as near as pixels are. The second level is a
 * window two pixels wide around it. This is the paper's CPU column; the part is the exact surface
 * here, not facets. */
#include "methods/internal.h"

typedef struct pixel {
    bool met;
    double x, y, height;
    btg_place place;
} pixel;

/* One window about (x, y) of the tool's own axes. */
static void look(const btg_pixels *p, const btg_tool_grid *g, double x0, double y0, double width,
                 pixel *best) {
    double pitch = width / p->window, ri = g->minor_radius;
    btg_place near = best->place;
    for (uint32_t j = 0; j < p->window; j++)
        for (uint32_t i = 0; i < p->window; i++) {
            double x = x0 + (i + 0.5) * pitch - 0.5 * width;
            double y = y0 + (j + 0.5) * pitch - 0.5 * width;
            double off = norm2(x, y) - g->major_radius, height;
            if (fabs(off) > ri) continue;
            btg_vec3 at = vec_mad(vec_mad(g->centre, g->a, x), g->b, y);
            at = vec_mad(at, g->axis, -sqrt((ri - off) * (ri + off)));
            if (!btg_under_find(p->under, g->axis, at, &near, &height)) continue;
            if (best->met && height <= best->height) continue;
            *best = (pixel){true, x, y, height, near};
        }
    btg_method_context_of(p->setup)->counts->rays += (uint64_t)p->window * p->window;
}

btg_status btg_pixels_drop(void *pixels, const btg_drop_query *queries, size_t count,
                           btg_drop_result *results) {
    const btg_pixels *p = pixels;
    for (size_t i = 0; i < count; i++) {
        const btg_drop_query *q = &queries[i];
        btg_tool_grid g = btg_tool_grid_place(&p->setup->tool, q->origin, q->axis);
        double width = 2 * (g.major_radius + g.minor_radius);
        pixel best = {.place = {.item = UINT32_MAX}};
        look(p, &g, 0, 0, width, &best);
        if (best.met && p->levels > 1) look(p, &g, best.x, best.y, 2 * width / p->window, &best);
        btg_drop_result r = {.status = BTG_NO_CONTACT, .bound_mm = NAN};
        if (best.met) {
            btg_ray_query query = btg_ray_query_drop(&p->setup->tool, q);
            const btg_patch *patch = &p->setup->part->patches[best.place.item];
            r.status = BTG_OK;
            r.height_mm = best.height;
            r.contact = btg_method_contact(&query, best.height, 0, best.place,
                                           btg_patch_point(patch, best.place.u, best.place.v));
        }
        results[i] = r;
    }
    return BTG_OK;
}

double btg_pixels_pitch(const btg_pixels *p) {
    const btg_tool_element *e = &p->setup->tool.element[0];
    double pitch = 2 * (e->ring_radius_mm + e->corner_radius_mm) / p->window;
    return p->levels > 1 ? 2 * pitch / p->window : pitch;
}
