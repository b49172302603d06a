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
    return 16 + BTG_LEAF_TRIANGLES +
           3 * ((size_t)part->node_depth + part->quarters_depth + CUTS_MAX);
}

/* TILT, close to P: the tool as placed is no deeper there than rounding, which makes values of
 * itself. */
static BTG_APART bool is_rounding(const btg_search *search, btg_vec3 point, uint32_t element) {
    const btg_ray_query *q = &search->query;
    return q->op == BTG_OP_TILT && vec_norm2(vec_sub(point, q->p)) < search->near_p2 &&
           btg_ray_tool_distance(&q->tool->element[element], search->at, point).distance >=
               -search->rounding;
}

bool btg_search_offer(btg_search *search, double value, btg_place place, btg_vec3 point,
                      uint32_t element, bool osculating) {
    if (!(value > search->value) || (!osculating && is_rounding(search, point, element)))
        return false;
    search->found = true;
    search->settled = false;
    search->osculating = osculating;
    search->value = value;
    search->at = btg_ray_place(&search->query, value);
    search->place = place;
    search->point = point;
    search->element = element;
    search->basin_stale = true;
    return true;
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

static BTG_APART void push_triangle(btg_search *search, const btg_piece *piece) {
    btg_cell cell;
    btg_cell_of_triangle(search->part, piece, &cell);
    btg_entry *e = push(search, cell.centre, btg_cell_radius(&cell));
    e->node = BTG_NODE_NONE;
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

/* The walk's start: the roots of the tree. */
static void start(btg_search *search) {
    search->top = 0;
    for (int i = 0; i < 2; i++) {
        if (search->part->root[i] == BTG_NODE_NONE) continue;
        btg_entry *e = push(search, vec(0, 0, 0), INFINITY);
        e->node = search->part->root[i];
        e->key = 0;
    }
}

/* ---- triangles ---------------------------------------------------------------------------- */

/* A centre that beats the best by more than rounding is worth a polish. */
static void try_place(btg_search *search, btg_vec3 point, btg_place place) {
    btg_ray_hit hit;
    if (!btg_ray_cast(&search->query, point, &hit)) return;
    double slack = search->query.op == BTG_OP_DROP ? 1e-14 * search->part->scale : 1e-14;
    if (hit.value > search->value + slack && !is_rounding(search, point, hit.element))
        btg_search_polish(search, place);
}

/* A cell that small holds nothing its centre does not, but for what it may be deeper. */
static bool at_the_end(btg_search *search, const btg_region *region) {
    if (region->radius > 0.25 * search->tolerance && search->top + 8 <= search->stack_size)
        return false;
    bool left = search->query.op == BTG_OP_TILT && btg_search_left_to_p(search, region, true);
    if (!left) search->deepest = max2(search->deepest, search->tolerance + region->radius);
    return true;
}

static BTG_APART void open_triangle(btg_search *search, const btg_region *region,
                                    const btg_piece *piece) {
    bool placed = search->found || search->query.op == BTG_OP_TILT;
    try_place(search, region->cell.centre, btg_cell_place(&region->cell));
    if (!placed && search->found) {
        start(search); /* anew, with the tool placed */
        return;
    }
    if (search->query.op == BTG_OP_TILT) btg_search_sheet_at_p(search, region);
    if (at_the_end(search, region)) return;
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
static BTG_APART bool first_contact(btg_search *search, const btg_block *block) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double near = FIRST_POLISH * (e->ring_radius_mm + e->corner_radius_mm), best = -INFINITY;
    int from = -1;
    for (int k = 0; k < 4; k++) {
        btg_ray_hit hit;
        if (block->radius[k] > near && block->hu > 0.1 && block->hv > 0.1) continue;
        if (!btg_ray_cast(&search->query, btg_block_vector(&block->at.s, k), &hit)) continue;
        if (hit.value > best) {
            best = hit.value;
            from = k;
        }
    }
    if (from < 0) return false;
    btg_search_polish(search, place_in(block, from, 0, 0));
    return search->found;
}

/* Cuts deeper than this part of the clearance are followed. What is shallower has the rest of the
 * clearance as a margin for its bounds: at all of it pieces along the line where the tool is just
 * that deep would be cut without end. */
#define CUT_SHARE 0.5

/* A place where the placed tool cuts into the block, sought where it does so deepest by the bounds;
 * false: none there. */
static BTG_APART bool find_cut(const btg_search *search, const btg_block *block,
                               const btg_block_bound *bound, btg_place *at) {
    int best = -1;
    double enough = CUT_SHARE * search->tolerance, depth = -enough;
    for (int k = 0; k < 4; k++) {
        double least = min2(bound->least[k], bound->distance[k]);
        if (!(least < depth) || bound->low[k] >= -search->tolerance) continue;
        depth = least;
        best = k;
    }
    if (best < 0) return false;
    *at = place_in(block, best, 0, 0);
    if (bound->distance[best] < -enough) return true;
    *at = place_in(block, best, bound->s[best], bound->t[best]);
    btg_surface_point s;
    btg_part_point(search->part, *at, &s);
    const btg_tool_element *e = &search->query.tool->element[0];
    return btg_ray_tool_distance(e, search->at, s.s).distance < -enough;
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

/* DROP, nothing met so far, the tool below all of the part: the block's part in its shadow. Where
 * that is a sliver at the shadow's side no centre stands in it. */
static BTG_APART bool first_graze(btg_search *search, const btg_block *block,
                                  btg_block_bound *bound) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_place at;
    btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
    if (block->radius[0] > FIRST_POLISH * (e->ring_radius_mm + e->corner_radius_mm)) return false;
    if (!find_cut(search, block, bound, &at)) return false;
    btg_search_polish(search, at);
    return search->found;
}

/* Quarters that are not clear, the farthest first. */
static BTG_APART int quarters_left(btg_search *search, const btg_block *block,
                                   const btg_block_bound *bound, int left[4]) {
    const btg_tool *tool = search->query.tool;
    int count = 0;
    for (int k = 0; k < 4; k++) {
        if (bound && btg_search_clear_at_once(search, bound, k)) continue;
        btg_region region = {.radius = block->radius[k]};
        btg_cell_of_block(block, k, &region.cell);
        if (btg_search_clear_piece(search, &region, bound, k)) continue;
        /* Bounds find cuts of the round corner alone. */
        if (!bound || tool->element_count > 1)
            try_place(search, region.cell.centre, place_in(block, k, 0, 0));
        if (search->query.op == BTG_OP_TILT) btg_search_sheet_at_p(search, &region);
        if (at_the_end(search, &region)) continue;
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
    bool placed = search->found || search->query.op == BTG_OP_TILT;
    size_t from = search->top;
    for (int i = 0; i < count; i++) {
        int k = left[i];
        btg_entry *e = push(search, btg_block_vector(&block->at.s, k), block->radius[k]);
        e->node = BTG_NODE_NONE;
        btg_block_quarter(search->part, block, k, &e->piece);
        e->key = placed && bound ? bound->low[k] : rank(search, e->centre, e->radius);
    }
    if (!placed || !bound) order(search, from);
}

static BTG_APART void open_piece(btg_search *search, const btg_piece *piece) {
    btg_block *block = &search->block;
    btg_block_make(search->part, piece, block);
    search->nodes += 3;
    bool round = search->query.tool->element[0].corner_radius_mm > 0;
    if (search->query.op == BTG_OP_DROP && !search->found) {
        btg_block_bound *bound = round ? &search->bounds : NULL;
        if (first_contact(search, block) || (round && first_graze(search, block, bound)))
            start(search); /* anew, with the tool placed */
        else
            push_quarters(search, block, bound);
        return;
    }
    if (round) bound_block(search, block, &search->bounds);
    push_quarters(search, block, round ? &search->bounds : NULL);
}

/* ---- out of budget ------------------------------------------------------------------------ */

/* TILT: what was left to the limits at P is too deep for the tolerance. The start pose, with no
 * tilt at all, is none the deeper for it. */
static bool start_alone_is_safe(const btg_search *search) {
    return search->query.op == BTG_OP_TILT && btg_search_deep_at_p(search) > 2 * search->deep_at_p;
}

/* Out of budget: no entry left has a value above the bound of its ball. */
static BTG_APART void give_up(btg_search *search) {
    search->spent = true;
    search->bound = search->value;
    for (size_t i = 0; i < search->top; i++) {
        const btg_entry *r = &search->stack[i];
        double value;
        for (uint32_t e = 0; e < search->query.tool->element_count; e++)
            if (btg_ray_ball_value(&search->query, e, r->centre, r->radius, &value))
                search->bound = max2(search->bound, value);
    }
    if (search->query.op == BTG_OP_DROP || search->bound >= 0) return;
    search->at = btg_ray_place(&search->query, search->bound);
    if (start_alone_is_safe(search)) search->bound = 0;
}

/* ---- nodes -------------------------------------------------------------------------------- */

/* Triangles of a leaf that are not clear at a glance wait by themselves. */
static BTG_APART void push_triangles(btg_search *search, const uint32_t *triangle, uint32_t count) {
    const btg_tool_element *e = &search->query.tool->element[0];
    bool placed = search->found || search->query.op == BTG_OP_TILT;
    bool bounded = placed && e->corner_radius_mm > 0;
    size_t from = search->top;
    for (uint32_t first = 0; first < count; first += 4) {
        uint32_t n = count - first < 4 ? count - first : 4;
        btg_block_bound *bound = &search->bounds;
        btg_block *block = &search->block;
        search->nodes += n;
        if (bounded) {
            btg_block_of_triangles(search->part, triangle + first, n, block);
            btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
        }
        for (uint32_t k = 0; k < n; k++) {
            btg_piece piece;
            if (bounded && btg_search_clear_at_once(search, bound, (int)k)) continue;
            btg_triangle_root(search->part->patch_count + triangle[first + k], &piece);
            push_triangle(search, &piece);
        }
    }
    order(search, from);
}

/* Child k of a node, not clear: it waits. */
static void push_child(btg_search *search, const btg_node *node, int k, double key) {
    const btg_part *part = search->part;
    const btg_block *block = &search->block;
    btg_entry *e = push(search, btg_block_vector(&block->at.s, k), block->radius[k]);
    e->key = key;
    e->node = BTG_NODE_NONE;
    if (node->kind[k] == BTG_CHILD_NODE)
        e->node = node->child[k];
    else if (node->kind[k] == BTG_CHILD_PIECE)
        e->piece = part->pieces[node->child[k]];
    else
        e->piece = (btg_piece){.item = BTG_CELL_MANY, .quarters = node->child[k], .cut = 0};
    e->count = node->count[k];
}

static BTG_APART void open_node(btg_search *search, const btg_node *node) {
    const btg_tool_element *e = &search->query.tool->element[0];
    bool placed = search->found || search->query.op == BTG_OP_TILT;
    bool bounded = placed && e->corner_radius_mm > 0;
    btg_block *block = &search->block;
    btg_block_bound *bound = bounded ? &search->bounds : NULL;
    size_t from = search->top;
    btg_block_of_node(node, block);
    search->nodes += 3;
    if (bounded) btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
    for (int k = 0; k < 4 && node->kind[k] != BTG_CHILD_NONE; k++) {
        if (bounded && btg_search_clear_at_once(search, bound, k)) continue;
        btg_region region = {.radius = block->radius[k]};
        btg_cell_of_child(block, k, &region.cell);
        if (btg_search_clear_piece(search, &region, bound, k)) continue;
        double key = bounded ? bound->low[k] : rank(search, region.cell.centre, region.radius);
        push_child(search, node, k, key);
    }
    order(search, from);
}

/* ---- the walk ----------------------------------------------------------------------------- */

/* The entry's place on the stack is free: it is read before anything is pushed. */
static void look_at(btg_search *search, const btg_entry *entry) {
    const btg_part *part = search->part;
    if (entry->node != BTG_NODE_NONE) {
        open_node(search, &part->nodes[entry->node]);
    } else if (entry->piece.item == BTG_CELL_MANY) {
        push_triangles(search, part->order + entry->piece.quarters, entry->count);
    } else if (!btg_is_triangle(part, entry->piece.item)) {
        open_piece(search, &entry->piece);
    } else {
        btg_region region = {.radius = entry->radius};
        btg_cell_of_triangle(part, &entry->piece, &region.cell);
        if (!btg_search_clear(search, &region)) open_triangle(search, &region, &entry->piece);
    }
}

/* The best may have come from a polish that ran out of steps in a flat valley. */
static void finish(btg_search *search) {
    for (int i = 0; i < FINISHES && search->found && !search->osculating && !search->settled; i++) {
        double before = search->value;
        btg_search_polish(search, search->place);
        if (search->value == before) break;
    }
}

void btg_search_run_near(btg_search *search) {
    search->at = btg_ray_place(&search->query, search->value);
    search->basin_stale = true;
    search->deepest = INFINITY;
    btg_search_near_p(search);
    btg_search_polish(search, search->start);
    finish(search);
}

/* DROP: a value that places the tool below all of the part. */
static double below_all(const btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double reach = 2 * search->part->scale + e->ring_radius_mm + e->corner_radius_mm;
    return -(reach + e->from_mm + vec_norm(search->query.o));
}

/* Everything that is not clear, cut or followed; false: out of budget. */
static bool walk(btg_search *search) {
    bool tilt = search->query.op == BTG_OP_TILT;
    start(search);
    while (search->top > 0) {
        if (tilt && search->value >= BTG_PI) return false; /* inside at any tilt */
        if (search->nodes >= search->budget) {
            give_up(search);
            return false;
        }
        search->nodes++;
        look_at(search, &search->stack[--search->top]);
    }
    return true;
}

void btg_search_run(btg_search *search) {
    bool tilt = search->query.op == BTG_OP_TILT;
    search->at = btg_ray_place(&search->query, tilt ? search->value : below_all(search));
    search->basin_stale = true;
    search->deepest = search->tolerance;
    if (tilt) btg_search_near_p(search);
    if (search->has_start) btg_search_polish(search, search->start);
    do
        if (!walk(search)) return;
    while (tilt && btg_search_come_close_to_p(search));
    if (start_alone_is_safe(search)) {
        search->spent = true;
        search->bound = 0;
        return;
    }
    if (tilt) btg_search_climb_ridges(search);
    finish(search);
}
