/* The walk through the part's trees (search.h). */
#include "core/search.h"

/* Cuts before a piece is as small as the rounding of its points; each leaves at most three on the
 * stack. */
#define CUTS_MAX 40

/* Polishes of the winner at the most, and from one block. */
#define FINISHES 4
#define POLISHES 3

/* Pieces below this part of the tool's radius are worth the first polish of a drop. */
#define FIRST_POLISH 0.25

size_t btg_search_stack_size(const btg_part *part) {
    return 16 + (size_t)part->node_depth + 3 * ((size_t)part->quarters_depth + CUTS_MAX);
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

/* ---- the stack ---------------------------------------------------------------------------- */

/* How soon a region shall be looked at: the smaller the sooner. */
static double rank(const btg_search *search, btg_vec3 c, double radius) {
    const btg_tool_element *e = &search->query.tool->element[0];
    if (search->query.op == BTG_OP_DROP && !search->found) {
        btg_vec3 d = vec_sub(c, search->query.o), w = search->query.w;
        double height = vec_dot(d, w), r = vec_norm(vec_mad(d, w, -height));
        double outside = r - e->ring_radius_mm - e->corner_radius_mm;
        return (outside > 0 ? outside : 0) - height - radius;
    }
    return btg_ray_tool_distance(e, search->at, c).distance - radius;
}

static btg_entry *push(btg_search *search, btg_vec3 centre, double radius) {
    btg_entry *e = &search->stack[search->top++];
    e->centre = centre;
    e->radius = radius;
    return e;
}

static void push_node(btg_search *search, uint32_t node) {
    const btg_box_node *n = &search->part->nodes[node];
    double x = (double)n->half[0], y = (double)n->half[1], z = (double)n->half[2];
    btg_entry *e =
        push(search, vec(n->centre[0], n->centre[1], n->centre[2]), sqrt(x * x + y * y + z * z));
    e->node = node;
    e->key = rank(search, e->centre, e->radius);
}

static void push_triangle(btg_search *search, const btg_piece *piece) {
    btg_cell cell;
    btg_cell_of_triangle(search->part, piece, &cell);
    btg_entry *e = push(search, cell.centre, btg_cell_radius(search->part, &cell));
    e->node = BTG_REGION_CELL;
    e->piece = *piece;
    e->key = rank(search, e->centre, e->radius);
}

/* Puts the newest entries in order, nearest on top. */
static void order(btg_search *search, size_t from) {
    for (size_t i = from + 1; i < search->top; i++) {
        btg_entry moved = search->stack[i];
        size_t k = i;
        for (; k > from && search->stack[k - 1].key < moved.key; k--)
            search->stack[k] = search->stack[k - 1];
        search->stack[k] = moved;
    }
}

static void push_item(btg_search *search, uint32_t item) {
    btg_piece piece;
    if (btg_is_triangle(search->part, item)) {
        btg_triangle_root(item, &piece);
        push_triangle(search, &piece);
        return;
    }
    btg_piece_root(search->part, item, &piece);
    btg_entry *e = push(search, search->part->patches[item].origin, INFINITY);
    e->node = BTG_REGION_CELL;
    e->piece = piece;
    e->key = 0;
}

static void open_node(btg_search *search, uint32_t node) {
    const btg_box_node *n = &search->part->nodes[node];
    size_t from = search->top;
    if (n->count == 0) {
        push_node(search, n->first);
        push_node(search, n->first + 1);
    }
    for (uint32_t i = 0; i < n->count; i++)
        push_item(search, search->part->items[n->first + i]);
    order(search, from);
}

/* ---- triangles ---------------------------------------------------------------------------- */

/* A centre that beats the best by more than rounding is worth a polish. */
static void try_place(btg_search *search, btg_vec3 point, btg_place place) {
    btg_ray_hit hit;
    if (!btg_ray_cast(&search->query, point, &hit)) return;
    double slack = search->query.op == BTG_OP_DROP ? 1e-14 * search->part->scale : 1e-14;
    if (hit.value > search->value + slack) btg_search_polish(search, place);
}

static bool at_the_end(const btg_search *search, double radius) {
    /* A cell that small holds nothing its centre does not. */
    return radius <= 0.25 * search->tolerance || search->top + 8 > search->stack_size;
}

static void open_triangle(btg_search *search, const btg_region *region, const btg_piece *piece) {
    try_place(search, region->cell.centre, btg_cell_place(search->part, &region->cell));
    if (search->query.op == BTG_OP_TILT) btg_search_sheet_at_p(search, region);
    if (at_the_end(search, region->radius)) return;
    btg_piece quarter[4];
    size_t from = search->top;
    btg_triangle_cut(piece, quarter);
    for (int i = 0; i < 4; i++)
        push_triangle(search, &quarter[i]);
    order(search, from);
}

/* ---- patches ------------------------------------------------------------------------------ */

static btg_place place_in(const btg_block *block, int k, double s, double t) {
    return (btg_place){block->whole.item, block->u[k] + s * block->hu, block->v[k] + t * block->hv};
}

/* DROP, nothing met so far: the best centre of the block is worth a polish when it is near enough
 * to the top. */
static bool first_contact(btg_search *search, const btg_block *block) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double near = FIRST_POLISH * (e->ring_radius_mm + e->corner_radius_mm), best = -INFINITY;
    int from = -1;
    for (int k = 0; k < 4; k++) {
        btg_ray_hit hit;
        if (block->radius[k] > near && block->hu > 0.1 && block->hv > 0.1) continue;
        if (!btg_ray_cast(&search->query, btg_block_vector(&block->centre, k), &hit)) continue;
        if (hit.value > best) {
            best = hit.value;
            from = k;
        }
    }
    if (from < 0) return false;
    btg_search_polish(search, place_in(block, from, 0, 0));
    return search->found;
}

/* A place where the placed tool cuts into the block, sought where it does so deepest by the bounds;
 * false: none there. */
static bool find_cut(const btg_search *search, const btg_block *block, const btg_block_bound *bound,
                     btg_place *at) {
    int best = -1;
    double depth = -search->tolerance;
    for (int k = 0; k < 4; k++) {
        double least = min2(bound->least[k], bound->distance[k]);
        if (!(least < depth) || bound->low[k] >= -search->tolerance) continue;
        depth = least;
        best = k;
    }
    if (best < 0) return false;
    *at = place_in(block, best, 0, 0);
    if (bound->distance[best] < -search->tolerance) return true;
    *at = place_in(block, best, bound->s[best], bound->t[best]);
    btg_surface_point s;
    btg_part_point(search->part, *at, &s);
    const btg_tool_element *e = &search->query.tool->element[0];
    return btg_ray_tool_distance(e, search->at, s.s).distance < -search->tolerance;
}

/* Bounds of the block's pieces for the tool as placed; where one is cut into, the place is followed
 * and the tool placed anew. */
static void bound_block(btg_search *search, const btg_block *block, btg_block_bound *bound) {
    const btg_tool_element *e = &search->query.tool->element[0];
    for (int i = 0;; i++) {
        btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
        btg_place at;
        if (i == POLISHES || !find_cut(search, block, bound, &at)) return;
        double before = search->value;
        btg_search_polish(search, at);
        if (search->value == before) return;
    }
}

/* Quarters that are not clear, the farthest first. */
static int quarters_left(btg_search *search, const btg_block *block, const btg_block_bound *bound,
                         int left[4]) {
    const btg_tool *tool = search->query.tool;
    int count = 0;
    for (int k = 0; k < 4; k++) {
        if (bound && btg_search_clear_at_once(search, bound, k)) continue;
        btg_region region = {.node = BTG_REGION_CELL, .radius = block->radius[k]};
        btg_cell_of_block(block, k, &region.cell);
        if (btg_search_clear_piece(search, &region, bound, k)) continue;
        /* Bounds find cuts of the round corner alone. */
        if (!bound || tool->element_count > 1)
            try_place(search, region.cell.centre, place_in(block, k, 0, 0));
        if (search->query.op == BTG_OP_TILT) btg_search_sheet_at_p(search, &region);
        if (at_the_end(search, region.radius)) continue;
        int i = count++;
        for (; bound && i > 0 && bound->low[left[i - 1]] < bound->low[k]; i--)
            left[i] = left[i - 1];
        left[i] = k;
    }
    return count;
}

static void push_quarters(btg_search *search, const btg_block *block,
                          const btg_block_bound *bound) {
    int left[4], count = quarters_left(search, block, bound, left);
    size_t from = search->top;
    for (int i = 0; i < count; i++) {
        int k = left[i];
        btg_entry *e = push(search, btg_block_vector(&block->centre, k), block->radius[k]);
        e->node = BTG_REGION_CELL;
        btg_block_quarter(search->part, block, k, &e->piece);
        e->key = bound ? bound->low[k] : rank(search, e->centre, e->radius);
    }
    if (!bound) order(search, from);
}

static void open_piece(btg_search *search, const btg_piece *piece) {
    btg_block *block = &search->block;
    btg_block_make(search->part, piece, block);
    search->nodes += 3;
    bool round = search->query.tool->element[0].corner_radius_mm > 0;
    if (search->query.op == BTG_OP_DROP && !search->found) {
        if (first_contact(search, block)) {
            search->top = 0; /* from the start, with the tool placed */
            push_node(search, 0);
        } else {
            push_quarters(search, block, NULL);
        }
        return;
    }
    btg_block_bound bound;
    if (round) bound_block(search, block, &bound);
    push_quarters(search, block, round ? &bound : NULL);
}

/* ---- the walk ----------------------------------------------------------------------------- */

/* Out of budget: no entry left has a value above the bound of its ball. */
static void give_up(btg_search *search) {
    search->spent = true;
    search->bound = search->value;
    for (size_t i = 0; i < search->top; i++) {
        const btg_entry *r = &search->stack[i];
        double value;
        for (uint32_t e = 0; e < search->query.tool->element_count; e++)
            if (btg_ray_ball_value(&search->query, e, r->centre, r->radius, &value))
                search->bound = max2(search->bound, value);
    }
}

static void look_at(btg_search *search, const btg_entry *entry) {
    if (entry->node == BTG_REGION_CELL && !btg_is_triangle(search->part, entry->piece.item)) {
        open_piece(search, &entry->piece);
        return;
    }
    btg_region region = {.node = entry->node, .radius = entry->radius};
    region.cell.centre = entry->centre;
    if (entry->node == BTG_REGION_CELL)
        btg_cell_of_triangle(search->part, &entry->piece, &region.cell);
    if (btg_search_clear(search, &region)) return;
    if (entry->node == BTG_REGION_CELL)
        open_triangle(search, &region, &entry->piece);
    else
        open_node(search, entry->node);
}

void btg_search_run(btg_search *search) {
    bool tilt = search->query.op == BTG_OP_TILT;
    search->at = btg_ray_place(&search->query, tilt ? search->value : 0);
    search->basin_stale = true;
    if (tilt) btg_search_near_p(search);
    if (search->has_start) btg_search_polish(search, search->start);
    push_node(search, 0);
    while (search->top > 0) {
        if (tilt && search->value >= BTG_PI) return; /* inside at any tilt */
        if (search->nodes >= search->budget) {
            give_up(search);
            return;
        }
        btg_entry entry = search->stack[--search->top];
        search->nodes++;
        look_at(search, &entry);
    }
    /* The best may have come from a polish that ran out of steps in a flat valley. */
    for (int i = 0; i < FINISHES && search->found && !search->osculating; i++) {
        double before = search->value;
        btg_search_polish(search, search->place);
        if (search->value == before) break;
    }
}
