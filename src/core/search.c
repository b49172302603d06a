/* The walk through the part's trees (search.h). */
#include "core/search.h"

/* Halvings of stored leaves and triangles before a cell is as small as the rounding of its
 * points; each leaves at most three regions on the stack. */
#define MADE_DEPTH 64

/* Polishes of the winner at the most. */
#define FINISHES 4

size_t btg_search_stack_size(const btg_part *part) {
    return 8 + (size_t)part->node_depth + part->tile_depth + 3 * MADE_DEPTH + 4;
}

void btg_search_offer(btg_search *search, double value, btg_place place, btg_vec3 point,
                      uint32_t element, bool osculating) {
    if (!(value > search->value)) return;
    search->found = true;
    search->osculating = osculating;
    search->value = value;
    search->at = btg_ray_place(&search->query, value);
    search->place = place;
    search->point = point;
    search->element = element;
    search->basin_stale = true;
}

/* Basins stand about the contacts of the tool as placed: made anew when that moves. */
static void renew_basins(btg_search *search) {
    search->basin_stale = false;
    search->basin[0].reach = search->basin[1].reach = 0;
    if (search->found && !search->osculating)
        search->basin[0] = btg_basin_make(search, search->place, search->element);
    if (search->query.op == BTG_OP_TILT)
        search->basin[1] = btg_basin_make(search, search->p_place, 0);
}

static void rank(const btg_search *search, btg_region *region) {
    btg_vec3 c = region->cell.centre;
    if (search->query.op == BTG_OP_DROP && !search->found) {
        btg_vec3 d = vec_sub(c, search->query.o), w = search->query.w;
        double height = vec_dot(d, w), r = vec_norm(vec_mad(d, w, -height));
        const btg_tool_element *e = &search->query.tool->element[0];
        double outside = r - e->ring_radius_mm - e->corner_radius_mm;
        region->key = (outside > 0 ? outside : 0) - height - region->radius;
        return;
    }
    const btg_tool_element *e = &search->query.tool->element[0];
    region->key = btg_ray_tool_distance(e, search->at, c).distance - region->radius;
}

static void push_node(btg_search *search, uint32_t node, size_t *top) {
    btg_region *region = &search->stack[*top];
    const btg_box_node *n = &search->part->nodes[node];
    region->node = node;
    region->cell.centre = vec(n->centre[0], n->centre[1], n->centre[2]);
    region->radius = sqrt((double)n->half[0] * n->half[0] + (double)n->half[1] * n->half[1] +
                          (double)n->half[2] * n->half[2]);
    rank(search, region);
    (*top)++;
}

static void push_cell(btg_search *search, size_t *top) {
    btg_region *region = &search->stack[*top];
    region->node = BTG_REGION_CELL;
    region->radius = btg_cell_radius(search->part, &region->cell);
    rank(search, region);
    (*top)++;
}

/* Puts the newest regions in order, nearest on top. */
static void order(btg_search *search, size_t from, size_t top) {
    for (size_t i = from + 1; i < top; i++) {
        btg_region moved = search->stack[i];
        size_t k = i;
        for (; k > from && search->stack[k - 1].key < moved.key; k--)
            search->stack[k] = search->stack[k - 1];
        search->stack[k] = moved;
    }
}

static void open_node(btg_search *search, uint32_t node, size_t *top) {
    const btg_box_node *n = &search->part->nodes[node];
    size_t from = *top;
    if (n->count == 0) {
        push_node(search, n->first, top);
        push_node(search, n->first + 1, top);
    }
    for (uint32_t i = 0; i < n->count; i++) {
        btg_cell_root(search->part, search->part->items[n->first + i], &search->stack[*top].cell);
        push_cell(search, top);
    }
    order(search, from, *top);
}

/* A centre that beats the best by more than rounding is worth a polish. */
static void try_centre(btg_search *search, const btg_region *region) {
    btg_ray_hit hit;
    if (!btg_ray_cast(&search->query, region->cell.centre, &hit)) return;
    double slack = search->query.op == BTG_OP_DROP ? 1e-14 * search->part->scale : 1e-14;
    if (hit.value <= search->value + slack) return;
    btg_search_polish(search, btg_cell_place(search->part, &region->cell));
}

static void open_cell(btg_search *search, const btg_region *region, size_t *top) {
    btg_cell child[BTG_CELL_CHILDREN_MAX];
    size_t from = *top;
    int count = btg_cell_split(search->part, &region->cell, child);
    for (int i = 0; i < count; i++) {
        search->stack[*top].cell = child[i];
        push_cell(search, top);
    }
    order(search, from, *top);
}

/* Out of budget: no region left has a value above the bound of its ball. */
static void give_up(btg_search *search, size_t top) {
    search->spent = true;
    search->bound = search->value;
    for (size_t i = 0; i < top; i++) {
        const btg_region *r = &search->stack[i];
        double value;
        for (uint32_t e = 0; e < search->query.tool->element_count; e++)
            if (btg_ray_ball_value(&search->query, e, r->cell.centre, r->radius, &value))
                search->bound = fmax(search->bound, value);
    }
}

void btg_search_run(btg_search *search) {
    size_t top = 0;
    bool tilt = search->query.op == BTG_OP_TILT;
    search->at = btg_ray_place(&search->query, tilt ? search->value : 0);
    search->basin_stale = true;
    if (tilt) btg_search_near_p(search);
    push_node(search, 0, &top);
    while (top > 0) {
        if (tilt && search->value >= BTG_PI) return; /* inside at any tilt */
        if (search->nodes == search->budget) {
            give_up(search, top);
            return;
        }
        btg_region region = search->stack[--top];
        search->nodes++;
        if (search->basin_stale) renew_basins(search);
        if (btg_search_clear(search, &region)) continue;
        if (region.node != BTG_REGION_CELL) {
            open_node(search, region.node, &top);
            continue;
        }
        try_centre(search, &region);
        if (tilt) btg_search_sheet_at_p(search, &region);
        /* A cell that small holds nothing its centre does not. */
        if (region.radius <= 0.25 * search->tolerance || top + 8 > search->stack_size) continue;
        open_cell(search, &region, &top);
    }
    /* The best may have come from a polish that ran out of steps in a flat valley. */
    for (int i = 0; i < FINISHES && search->found && !search->osculating; i++) {
        double before = search->value;
        btg_search_polish(search, search->place);
        if (search->value == before) break;
    }
}
