/* What the ring that has been proven covers (ring.c): pieces that are wholly within its width and
 * its parameters, and that no open wedge meets. */
#include "core/search.h"

bool btg_ring_covers(const btg_search *search, const btg_entry *e) {
    const btg_ring *ring = &search->ring;
    if (search->ring.stale || !ring->stands || search->query.tool->element_count > 1) return false;
    if (e->node != BTG_NODE_NONE || e->piece.item != ring->item) return false;
    btg_vec3 d = vec_sub(e->centre, search->at.centre);
    double x = vec_dot(d, ring->x), y = vec_dot(d, ring->y), z = vec_dot(d, search->at.axis);
    double dr = sqrt(x * x + y * y) - ring->radius, dz = z - ring->height;
    double room = ring->wide - e->radius, radius = e->radius * (1 + 1e-9);
    if (!(room > 0 && dr * dr + dz * dz < room * room && z < -radius)) return false;
    if (!(fabs(e->piece.u - ring->u) + e->piece.hu < ring->half_u)) return false;
    if (!(fabs(e->piece.v - ring->v) + e->piece.hv < ring->half_v)) return false;
    for (uint32_t k = 0; k < ring->open; k++) {
        const btg_wedge *w = &ring->wedge[k];
        if (!(max2(x * w->low[0] + y * w->low[1], x * w->high[0] + y * w->high[1]) > radius))
            return false;
    }
    return true;
}

/* What waits has been asked before there was a ring. */
static BTG_APART void sweep(btg_search *search) {
    size_t left = 0;
    for (size_t i = 0; i < search->top; i++)
        if (!btg_ring_covers(search, &search->stack[i])) {
            if (left != i) search->stack[left] = search->stack[i];
            left++;
        }
    search->top = left;
}

void btg_ring_make(btg_search *search) {
    btg_ring_prove(search);
    if (search->ring.stands) sweep(search);
}

/* Bits of the pieces from number i on that no open wedge meets, within the ring's width and its
 * parameters. */
static BTG_APART unsigned within(const btg_search *search, uint32_t i) {
    const btg_ring *ring = &search->ring;
    const btg_block *block = &search->block;
    lanes3 s = lanes3_load(&block->at.s, (int)i);
    s = (lanes3){lanes_sub(s.x, lanes_all(search->at.centre.x)),
                 lanes_sub(s.y, lanes_all(search->at.centre.y)),
                 lanes_sub(s.z, lanes_all(search->at.centre.z))};
    lanes x = btg_block_dot(s, ring->x), y = btg_block_dot(s, ring->y),
          radius = lanes_load(block->radius + i);
    lanes dr = lanes_sqrt(lanes_mad(lanes_mul(x, x), y, y));
    dr = lanes_sub(dr, lanes_all(ring->radius));
    lanes dz = lanes_sub(btg_block_dot(s, search->at.axis), lanes_all(ring->height));
    lanes room = lanes_max(lanes_sub(lanes_all(ring->wide), radius), lanes_all(0));
    unsigned in = lanes_less(lanes_mad(lanes_mul(dr, dr), dz, dz), lanes_mul(room, room));
    lanes u = lanes_abs(lanes_sub(lanes_load(block->u + i), lanes_all(ring->u)));
    lanes v = lanes_abs(lanes_sub(lanes_load(block->v + i), lanes_all(ring->v)));
    in &= lanes_less(lanes_add(u, lanes_load(block->hu + i)), lanes_all(ring->half_u));
    in &= lanes_less(lanes_add(v, lanes_load(block->hv + i)), lanes_all(ring->half_v));
    for (uint32_t k = 0; in && k < ring->open; k++) {
        const btg_wedge *w = &ring->wedge[k];
        lanes low = lanes_mad(lanes_mul(x, lanes_all(w->low[0])), y, lanes_all(w->low[1]));
        lanes high = lanes_mad(lanes_mul(x, lanes_all(w->high[0])), y, lanes_all(w->high[1]));
        in &= lanes_less(lanes_mul(radius, lanes_all(1 + 1e-9)), lanes_max(low, high));
    }
    return in;
}

unsigned btg_ring_covering(const btg_search *search, unsigned bits) {
    const btg_block *block = &search->block;
    if (search->ring.stale || !search->ring.stands || block->triangles) return 0;
    unsigned covered = 0;
    for (uint32_t i = 0; i < block->count; i += BTG_LANES)
        covered |= within(search, i) << i;
    covered &= bits;
    for (unsigned rest = covered; rest; rest &= rest - 1) {
        int k = btg_lowest_bit(rest);
        if (block->item[k] != search->ring.item) covered &= ~(1u << k);
    }
    return covered;
}
