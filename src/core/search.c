/* The walk through the part's trees (search.h). */
#include "core/search.h"

/* Cuts before a piece is as small as the rounding of its points. Entries opened together leave
 * BTG_BLOCK at most, and of each such lot all but one may wait below the next one: entries of a lot
 * are cut at least as often as the lots below it are many. */
#define CUTS_MAX 40

/* Polishes of the winner at the most, and from one block. */
#define FINISHES 4
#define POLISHES 3

/* Leaves of triangles that are opened together. */
#define LEAVES (BTG_BLOCK / BTG_LEAF_TRIANGLES)

/* Pieces below this part of the tool's radius are worth the first polish of a drop. */
#define FIRST_POLISH 0.25

/* A drop's first contact is sought outside the tool's shadow only after places so much higher, part
 * of the way out of it. */
#define OUTSIDE 2

size_t btg_search_stack_size(const btg_part *part) {
    return 16 + BTG_LEAF_TRIANGLES +
           (BTG_BLOCK - 1) * ((size_t)part->node_depth + part->quarters_depth + CUTS_MAX);
}

/* TILT, close to P: the tool as placed is no deeper there than rounding, which makes values of
 * itself. */
static BTG_APART bool is_rounding(const btg_search *search, btg_vec3 point, uint32_t element) {
    const btg_ray_query *q = &search->query;
    return q->op == BTG_OP_TILT && vec_norm2(vec_sub(point, q->p)) < search->near_p2 &&
           btg_ray_tool_gap(&q->tool->element[element], &search->at, point) >= -search->rounding;
}

/* The tool at a value. Apart, as no compiler spares it a copy on the stack. */
static BTG_APART void place_at(btg_search *search, double value) {
    search->at = btg_ray_place(&search->query, value);
}

bool btg_search_offer(btg_search *search, double value, btg_place place, btg_vec3 point,
                      uint32_t element, bool osculating) {
    if (!(value > search->value) || (!osculating && is_rounding(search, point, element)))
        return false;
    search->found = true;
    search->settled = false;
    search->osculating = osculating;
    search->value = value;
    place_at(search, value);
    search->place = place;
    search->point = point;
    search->element = element;
    search->basin_stale = search->ring.stale = true;
    return true;
}

/* The tool stands where it touches the part, or where it starts its turn. */
static bool placed(const btg_search *search) {
    return search->found || search->query.op == BTG_OP_TILT;
}

/* ---- the stack ---------------------------------------------------------------------------- */

/* DROP, nothing met so far. The tool comes to rest near what it meets first: among triangles, where
 * a contact is polished on its own one alone, near the centre that it meets first; on patches a
 * polish goes a long way, and what counts is how high a ball may reach. */
static double first_rank(const btg_search *search, btg_vec3 c, double radius) {
    const btg_tool_element *e = &search->query.tool->element[0];
    bool triangles = search->part->triangle_count > 0;
    btg_ray_hit hit;
    if (triangles && btg_ray_cast(&search->query, c, &hit)) return -hit.value;
    btg_vec3 d = vec_sub(c, search->query.o), w = search->query.w;
    double height = vec_dot(d, w), r = vec_norm(vec_mad(d, w, -height));
    double outside = max2(r - e->ring_radius_mm - e->corner_radius_mm, 0);
    return triangles ? OUTSIDE * outside - height : outside - height - radius;
}

/* How soon a region shall be looked at: the smaller the sooner. */
static double rank(const btg_search *search, btg_vec3 c, double radius) {
    if (!placed(search)) return first_rank(search, c, radius);
    return btg_ray_tool_gap(&search->query.tool->element[0], &search->at, c) - radius;
}

static btg_entry *push(btg_search *search, btg_vec3 centre, double radius) {
    btg_entry *e = &search->stack[search->top++];
    e->centre = centre;
    e->radius = radius;
    return e;
}

/* Puts all that waits in order, nearest on top. */
static void order(btg_search *search) {
    for (size_t i = 1; i < search->top; i++) {
        btg_entry moved = search->stack[i];
        size_t k = i;
        for (; k > 0 && search->stack[k - 1].key < moved.key; k--)
            search->stack[k] = search->stack[k - 1];
        search->stack[k] = moved;
    }
}

/* DROP: the tool has met its first contact. What waits is ordered by its distance from it, and left
 * where its ball is clear of it. */
static BTG_APART void order_anew(btg_search *search) {
    size_t left = 0;
    bool one = search->query.tool->element_count == 1;
    for (size_t i = 0; i < search->top; i++) {
        btg_entry *e = &search->stack[i];
        e->key = e->radius < INFINITY ? rank(search, e->centre, e->radius) : -INFINITY;
        if (!one || e->key < -search->tolerance) search->stack[left++] = *e;
    }
    search->top = left;
    order(search);
}

BTG_APART bool btg_search_start_gouges(const btg_search *search, btg_vec3 point, uint32_t element) {
    const btg_tool_element *e = &search->query.tool->element[element];
    btg_placement start = btg_ray_place(&search->query, 0);
    double most = element > 0 ? search->touch : search->gouge;
    return -btg_ray_tool_gap(e, &start, point) > most;
}

/* ---- blocks ------------------------------------------------------------------------------- */

/* A cell no larger than that is not worth a cut: it holds nothing its centre does not, but for what
 * it may be deeper. */
static double least_cut(const btg_search *search) {
    bool full = search->top + BTG_BLOCK > search->stack_size;
    return full ? INFINITY : 0.25 * search->tolerance;
}

static bool at_the_end(btg_search *search, const btg_region *region) {
    if (region->radius > least_cut(search)) return false;
    bool left = search->query.op == BTG_OP_TILT && btg_search_left_to_p(search, region, true);
    if (!left) search->deepest = max2(search->deepest, search->tolerance + region->radius);
    return true;
}

/* A place well inside a piece. */
static btg_vec3 middle_of(const btg_block *block, int k, btg_place *place) {
    double to = block->triangles ? -1.0 / 3 : 0;
    if (place) *place = btg_block_place(block, k, to, to);
    btg_vec3 a = btg_block_vector(&block->at.su, k), b = btg_block_vector(&block->at.sv, k);
    return vec_mad(btg_block_vector(&block->at.s, k), vec_add(a, b), to);
}

/* The centre of the block with the best value; false: none near enough to the top. */
static BTG_APART bool best_centre(const btg_search *search, const btg_block *block,
                                  btg_place *place) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double near = FIRST_POLISH * (e->ring_radius_mm + e->corner_radius_mm), best = -INFINITY;
    int from = -1;
    for (int k = 0; k < (int)block->count; k++) {
        btg_ray_hit hit;
        bool wide = block->radius[k] > near && block->hu[k] > 0.1 && block->hv[k] > 0.1;
        if (wide && !block->triangles) continue;
        if (!btg_ray_cast(&search->query, middle_of(block, k, NULL), &hit)) continue;
        if (hit.value > best) {
            best = hit.value;
            from = k;
        }
    }
    if (from >= 0) middle_of(block, from, place);
    return from >= 0;
}

/* DROP, nothing met so far: the best centre of the block is worth a polish. */
static BTG_APART void first_contact(btg_search *search, const btg_block *block) {
    btg_place place;
    if (best_centre(search, block, &place)) btg_search_polish(search, place);
}

/* Cuts deeper than this part of the clearance are followed. What is shallower has the rest of the
 * clearance as a margin for its bounds: at all of it pieces along the line where the tool is just
 * that deep would be cut without end. */
#define CUT_SHARE 0.5

/* A place where the placed tool cuts into the block, sought where it does so deepest by the bounds;
 * false: none there. */
static BTG_APART bool find_cut(btg_search *search, const btg_block *block,
                               const btg_block_bound *bound, btg_place *at) {
    int best = -1;
    double enough = CUT_SHARE * search->tolerance, depth = -enough;
    for (unsigned left = bound->deep; left; left &= left - 1) {
        int k = btg_lowest_bit(left);
        double least = min2(bound->least[k], bound->distance[k]);
        if (!(least < depth)) continue;
        depth = least;
        best = k;
    }
    if (best < 0) return false;
    *at = btg_block_place(block, best, 0, 0);
    if (bound->distance[best] < -enough) return true;
    *at = btg_block_place(block, best, bound->s[best], bound->t[best]);
    btg_part_point(search->part, *at, &search->here);
    const btg_tool_element *e = &search->query.tool->element[0];
    return btg_ray_tool_gap(e, &search->at, search->here.s) < -enough;
}

/* Bounds by the pieces' balls alone. */
static void bound_balls(const btg_search *search, const btg_block *block, btg_block_bound *bound) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_block_bounds(block, e, &search->at, -INFINITY, bound);
    for (uint32_t k = 0; k < block->count; k++)
        if (bound->low[k] < -search->tolerance) bound->deep |= 1u << k;
}

/* Bounds of the block's pieces for the tool as placed; where one is cut into, the place is followed
 * and the tool placed anew. DROP, nothing met so far: the tool stands below all of the part, so
 * that pieces are cut into where they are in its shadow. */
static void bound_pieces(btg_search *search, const btg_block *block, btg_block_bound *bound) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double near = FIRST_POLISH * (e->ring_radius_mm + e->corner_radius_mm);
    /* small ones only: in a sliver of the shadow's side no centre stands */
    if (!placed(search) && block->radius[0] > near) {
        bound_balls(search, block, bound);
        return;
    }
    for (int i = 0;; i++) {
        btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
        btg_place at;
        if (i == POLISHES || !find_cut(search, block, bound, &at)) return;
        double before = search->value;
        btg_search_polish(search, at);
        if (search->value == before) return;
    }
}

/* How soon piece k shall be looked at: the smaller the sooner. */
static BTG_APART double key_of(const btg_search *search, const btg_block *block,
                               const btg_block_bound *bound, int k) {
    if (!bound || !placed(search))
        return rank(search, btg_block_vector(&block->at.s, k), block->radius[k]);
    /* a ball that is clear by itself may have no other bounds */
    double ball = bound->distance[k] - block->radius[k];
    return ball >= -search->tolerance ? ball : bound->low[k];
}

/* What will be read soon is on its way from memory. */
static void fetch(const void *from, size_t size) {
#if defined(__GNUC__)
    for (size_t i = 0; i < size; i += 64)
        __builtin_prefetch((const char *)from + i);
#else
    (void)from, (void)size;
#endif
}

static void fill_child(const btg_part *part, const btg_node *node, int k, btg_entry *e) {
    e->node = BTG_NODE_NONE;
    if (node->kind[k] == BTG_CHILD_NODE) {
        e->node = node->child[k];
        fetch(&part->nodes[node->child[k]], sizeof(btg_node));
    } else if (node->kind[k] == BTG_CHILD_PIECE) {
        e->piece = part->pieces[node->child[k]];
    } else {
        e->piece = (btg_piece){.item = BTG_CELL_MANY, .quarters = node->child[k], .cut = 0};
        fetch(part->order + node->child[k], 1);
    }
    e->count = node->count[k];
}

static btg_vec3 centre_of(const btg_node *node, int k) {
    return vec((double)node->centre[0][k], (double)node->centre[1][k], (double)node->centre[2][k]);
}

/* What waits at first: the roots of the tree; where the tool stands somewhere, what is below them.
 */
static void start(btg_search *search) {
    const btg_part *part = search->part;
    search->top = 0;
    for (int i = 0; i < 2; i++) {
        if (part->root[i] == BTG_NODE_NONE) continue;
        const btg_node *root = placed(search) ? &part->nodes[part->root[i]] : NULL;
        for (int k = 0; k < (root ? 4 : 1); k++) {
            if (root && root->kind[k] == BTG_CHILD_NONE) continue;
            btg_entry *e = root ? push(search, centre_of(root, k), (double)root->radius[k])
                                : push(search, vec(0, 0, 0), INFINITY);
            e->node = part->root[i];
            e->key = 0;
            if (root) fill_child(part, root, k, e);
        }
    }
}

/* The pieces of bits `left` wait, the nearest on top: children of `node`, or, NULL, quarters. Once
 * the tool has met something most will have to be opened, in whatever order; but a drop on
 * triangles has the best one yet to find. */
static void push_left(btg_search *search, const btg_block *block, const btg_block_bound *bound,
                      const btg_node *const node[], unsigned left) {
    double key[BTG_BLOCK];
    int order[BTG_BLOCK], count = 0;
    bool tilt = search->query.op == BTG_OP_TILT, patches = !node && !block->triangles;
    bool any_order = bound && search->found && (tilt || patches);
    for (; left; left &= left - 1) {
        int k = btg_lowest_bit(left), i = count++;
        double own = any_order ? 0 : key_of(search, block, bound, k);
        for (; !any_order && i > 0 && key[i - 1] < own; i--) {
            key[i] = key[i - 1];
            order[i] = order[i - 1];
        }
        key[i] = own;
        order[i] = k;
    }
    for (int i = 0; i < count; i++) {
        int k = order[i];
        btg_entry *e = push(search, btg_block_vector(&block->at.s, k), block->radius[k]);
        e->key = key[i];
        if (node) {
            fill_child(search->part, node[k / 4], k % 4, e);
            if (btg_ring_covers(search, e)) search->top--;
        } else {
            e->node = BTG_NODE_NONE;
            btg_block_quarter(search->part, block, k, &e->piece);
        }
    }
}

/* A centre that beats the best by more than rounding is worth a polish. One that is in the tool's
 * start pose ends the search: where a shank cuts into the part the best value is at the end of the
 * cut, where the value jumps, and no piece there is ever clear. */
static BTG_APART bool worth_a_polish(btg_search *search, int k, btg_place *place) {
    btg_ray_hit hit;
    btg_vec3 point = middle_of(&search->block, k, place);
    if (!btg_ray_cast(&search->query, point, &hit)) return false;
    bool tilt = search->query.op == BTG_OP_TILT;
    if (tilt && hit.value > 0)
        search->gouges |= btg_search_start_gouges(search, point, hit.element);
    double slack = tilt ? 1e-14 : 1e-14 * search->part->scale;
    return hit.value > search->value + slack && !is_rounding(search, point, hit.element);
}

static void try_middles(btg_search *search, unsigned bits) {
    for (; bits; bits &= bits - 1) {
        btg_place place;
        if (worth_a_polish(search, btg_lowest_bit(bits), &place)) btg_search_polish(search, place);
    }
}

/* Of quarters that are not clear, those that are worth another cut. */
static BTG_APART unsigned worth_cutting(btg_search *search, const btg_block *block, bool bounded,
                                        unsigned left) {
    bool one = search->query.tool->element_count == 1, tilt = search->query.op == BTG_OP_TILT;
    /* Bounds find cuts of the round corner alone. */
    if (!bounded || !one) try_middles(search, left);
    unsigned at_p = tilt ? left & btg_search_reaching_p(search) : 0;
    unsigned ended = left & btg_block_small(block, least_cut(search));
    for (unsigned bits = ended | at_p; bits; bits &= bits - 1) {
        int k = btg_lowest_bit(bits);
        const btg_region *region = btg_search_region(search, k, true);
        if (at_p >> k & 1) btg_search_sheet_at_p(search, region);
        if (at_the_end(search, region)) left &= ~(1u << k);
    }
    return left;
}

/* The block's pieces, fresh. */
static void open_block(btg_search *search) {
    btg_block *block = &search->block;
    bool round = search->query.tool->element[0].corner_radius_mm > 0, first = !placed(search);
    btg_block_bound *bound = round ? &search->bounds : NULL;
    if (first) first_contact(search, block);
    if (round) bound_pieces(search, block, bound);
    if (first && search->found) order_anew(search);
    unsigned left = btg_search_left(search, bound, btg_block_bits(block), true);
    if (left) left = worth_cutting(search, block, round, left);
    push_left(search, block, bound, NULL, left);
}

/* ---- out of budget ------------------------------------------------------------------------ */

/* TILT: what was left to the limits at P is too deep for the tolerance. The start pose, with no
 * tilt at all, is none the deeper for it. */
static bool start_alone_is_safe(btg_search *search) {
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
    place_at(search, search->bound);
    if (start_alone_is_safe(search)) search->bound = 0;
}

/* ---- nodes -------------------------------------------------------------------------------- */

static BTG_APART void open_nodes(btg_search *search, const btg_node *const node[], uint32_t nodes) {
    const btg_tool_element *e = &search->query.tool->element[0];
    btg_block *block = &search->block;
    btg_block_bound *bound = e->corner_radius_mm > 0 ? &search->bounds : NULL;
    unsigned left = 0;
    btg_block_of_nodes(node, nodes, block);
    search->nodes += block->count - 1;
    for (uint32_t k = 0; k < block->count; k++)
        if (node[k / 4]->kind[k % 4] != BTG_CHILD_NONE) left |= 1u << k;
    if (bound && placed(search))
        btg_block_bounds(block, e, &search->at, -search->tolerance, bound);
    else if (bound)
        bound_balls(search, block, bound);
    push_left(search, block, bound, node, btg_search_left(search, bound, left, false));
}

/* ---- the walk ----------------------------------------------------------------------------- */

static bool waits_node(const btg_search *search) {
    return search->top > 0 && search->stack[search->top - 1].node != BTG_NODE_NONE;
}

static bool waits_item(const btg_search *search, bool leaf) {
    if (search->top == 0) return false;
    const btg_entry *e = &search->stack[search->top - 1];
    return e->node == BTG_NODE_NONE && (e->piece.item == BTG_CELL_MANY) == leaf;
}

static bool waits_piece(const btg_search *search) {
    return waits_item(search, false);
}

static bool waits_leaf(const btg_search *search) {
    return waits_item(search, true);
}

/* So many are opened together: once the tool has met something, most will have to be. */
static uint32_t together(const btg_search *search) {
    return search->found ? BTG_PIECES : 2;
}

/* The triangles of leaves, together. They lie far and wide in memory: all are asked for before any
 * is read. */
static void look_at_leaves(btg_search *search) {
    const btg_part *part = search->part;
    uint32_t triangle[BTG_BLOCK], n = 0;
    for (uint32_t most = BTG_LEAF_TRIANGLES * (search->found ? LEAVES : 1);
         n + BTG_LEAF_TRIANGLES <= most && waits_leaf(search);) {
        const btg_entry *leaf = &search->stack[--search->top];
        for (uint32_t i = 0; i < leaf->count; i++, n++) {
            triangle[n] = part->order[leaf->piece.quarters + i];
            fetch(part->triangles[triangle[n]], sizeof *part->triangles);
        }
    }
    btg_block_of_triangles(part, triangle, n, &search->block);
    search->nodes += n;
    open_block(search);
}

/* Looks at what is on top of the stack: nodes together, and pieces, all of patches or all of
 * triangles. Entries that are taken are read before anything is pushed. */
static void look_at_top(btg_search *search) {
    const btg_part *part = search->part;
    if (waits_node(search)) {
        const btg_node *node[BTG_PIECES];
        uint32_t n = 0;
        for (uint32_t most = placed(search) ? together(search) : 1; n < most && waits_node(search);
             n++)
            node[n] = &part->nodes[search->stack[--search->top].node];
        search->nodes += n - 1;
        open_nodes(search, node, n);
        return;
    }
    if (waits_leaf(search)) {
        look_at_leaves(search);
        return;
    }
    const btg_piece *piece[BTG_PIECES] = {&search->stack[--search->top].piece};
    bool triangle = btg_is_triangle(part, piece[0]->item);
    uint32_t n = 1;
    for (uint32_t most = together(search); n < most && waits_piece(search); n++) {
        const btg_piece *next = &search->stack[search->top - 1].piece;
        if (btg_is_triangle(part, next->item) != triangle) break;
        piece[n] = next;
        search->top--;
    }
    btg_block_make(part, piece, n, &search->block);
    search->nodes += n - 1 + search->block.count - 1;
    open_block(search);
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
    place_at(search, search->value);
    search->basin_stale = search->ring.stale = true;
    search->deepest = INFINITY;
    btg_search_near_p(search);
    btg_search_polish(search, search->start);
    finish(search);
}

/* DROP on patches: the piece that the ranks alone lead to, straight down the tree. False: there are
 * triangles, each of which has to be climbed on its own. */
static BTG_APART bool first_piece(btg_search *search, btg_place *at) {
    const btg_part *part = search->part;
    if (part->root[1] != BTG_NODE_NONE || search->query.op == BTG_OP_TILT) return false;
    for (uint32_t n = part->root[0];;) {
        const btg_node *node = &part->nodes[n];
        int best = 0;
        double least = INFINITY;
        for (int k = 0; k < 4 && node->kind[k] != BTG_CHILD_NONE; k++) {
            double own = first_rank(search, centre_of(node, k), (double)node->radius[k]);
            if (own >= least) continue;
            least = own;
            best = k;
        }
        search->nodes++;
        n = node->child[best];
        if (node->kind[best] == BTG_CHILD_NODE) continue;
        *at = (btg_place){part->pieces[n].item, part->pieces[n].u, part->pieces[n].v};
        return true;
    }
}

/* DROP: a value that places the tool below all of the part. */
static double below_all(const btg_search *search) {
    const btg_tool_element *e = &search->query.tool->element[0];
    double reach = 2 * search->part->scale + e->ring_radius_mm + e->corner_radius_mm;
    return -(reach + e->from_mm + vec_norm(search->query.o));
}

/* Everything that is not clear, cut or followed; false: out of budget. */
static BTG_APART bool walk(btg_search *search) {
    bool tilt = search->query.op == BTG_OP_TILT;
    start(search);
    while (search->top > 0) {
        if (tilt && (search->gouges || search->value >= BTG_PI)) return false; /* never free */
        if (search->nodes >= search->budget) {
            give_up(search);
            return false;
        }
        if (search->ring.stale) {
            btg_ring_make(search);
            continue;
        }
        search->nodes++;
        look_at_top(search);
    }
    return true;
}

void btg_search_run(btg_search *search) {
    bool tilt = search->query.op == BTG_OP_TILT;
    place_at(search, tilt ? search->value : below_all(search));
    search->basin_stale = search->ring.stale = true;
    search->deepest = search->tolerance;
    if (tilt) btg_search_near_p(search);
    btg_place first;
    if (search->has_start)
        btg_search_polish(search, search->start);
    else if (tilt ? btg_ring_start(search, &first) : first_piece(search, &first))
        btg_search_polish(search, first);
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
