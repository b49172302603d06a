/* The largest value over the part, by one workgroup a query.
 *
 * A walk through a tree of balls: all invocations test children of the nodes on top of a shared
 * stack, then try the cells left by a grid of samples on the cell's quadratic piece. What a ball's
 * bound shows below the best so far is left out. The winner is then followed on the surface itself,
 * by grids that shrink about the best place, where the answer is to be taken as it is; the core's
 * polish does that by itself.
 *
 * Whatever the order of invocations, the same place wins: all compare with a bound that stands for
 * the round, and equal values are told apart by cell and sample. */

#if defined VULKAN || defined GL_SPIRV
layout(local_size_x_id = 0, local_size_y = 1, local_size_z = 1) in;
#else
layout(local_size_x = BTG_GROUP, local_size_y = 1, local_size_z = 1) in;
#endif

const uint STACK = 768;
const uint SIZE_MAX = 64;
/* No batch needs as many; a bound all the same. */
const uint ROUNDS = 1u << 22;
/* Bounds are loosened by that part of what they are made of: rounding. */
const float SLACK = 2e-6;

const uint GRID = 7;   /* samples a side when following the winner: odd, the middle is one */
const uint ZOOM = 3;   /* grids on each expansion */
const float SHRINK = 0.34;

shared uint stack[STACK];
shared uint list[2 * SIZE_MAX];
shared uint top, waiting, node_bits[2], cell_bits[2];
shared uint bound_key; /* some point of the part has that value */
shared uint best_key, best_index, tried, full;
shared vec4 best_place; /* u, v, half sides of the grid to come */
shared uint best_cell;

/* Unsigned numbers in the order of floats. */
uint key_of(float x) {
    uint b = floatBitsToUint(x);
    return (b & 0x80000000u) != 0 ? ~b : b | 0x80000000u;
}

float value_of(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0 ? key & 0x7fffffffu : ~key);
}

bool can_win(btg_gpu_query q, vec4 ball, float best) {
    vec3 s = (ball.xyz - q.origin.xyz) - q.origin_low.xyz;
    float value;
    float radius = ball.w + SLACK * (ball.w + abs(s.x) + abs(s.y) + abs(s.z));
    if (!ray_ball_value(q, s, radius, value)) return false;
    return value + SLACK * (1 + abs(value)) >= best;
}

/* Entries among those below this invocation's bit. */
uint below(uint bits0, uint bits1, uint lane) {
    uint mask = (1u << (lane & 31u)) - 1;
    return lane < 32 ? bitCount(bits0 & mask) : bitCount(bits0) + bitCount(bits1 & mask);
}

/* A cell's centre is a point of the part. */
void raise_bound(btg_gpu_query q, vec4 ball) {
    btg_ray_hit hit;
    vec3 s = (ball.xyz - q.origin.xyz) - q.origin_low.xyz;
    if (ray_cast(q, s, hit)) atomicMax(bound_key, key_of(hit.value));
}

/* Children of the nodes on top; held, left: what stack and list hold. */
void open_nodes(btg_gpu_query q, uint held, uint left, float bound) {
    uint lane = gl_LocalInvocationIndex, nodes = min(held, gl_WorkGroupSize.x / BTG_GPU_FAN);
    nodes = min(nodes, (STACK - held) / (BTG_GPU_FAN - 1));
    bool overflow = nodes == 0;
    nodes = max(nodes, 1);
    uint entry_ = 0, mine = lane / BTG_GPU_FAN;
    bool keep = false, cell = false;
    if (mine < nodes && !overflow) {
        uint parent = stack[held - 1 - mine], level = (parent >> 28) - 1;
        uint index = (parent & 0x0fffffffu) * BTG_GPU_FAN + lane % BTG_GPU_FAN;
        uvec4 here = scene.level[level];
        cell = level == 0;
        entry_ = (level << 28) | index;
        vec4 ball = vec4(0);
        if (index < here.y) {
            ball = geometry[here.x + index];
            keep = can_win(q, ball, bound);
        }
        if (keep && cell) {
            atomicOr(cell_bits[lane >> 5], 1u << (lane & 31u));
            raise_bound(q, ball);
        }
        if (keep && !cell) atomicOr(node_bits[lane >> 5], 1u << (lane & 31u));
    }
    barrier();
    uint n0 = node_bits[0], n1 = node_bits[1], c0 = cell_bits[0], c1 = cell_bits[1];
    if (keep && cell) list[left + below(c0, c1, lane)] = entry_;
    if (keep && !cell) stack[held - nodes + below(n0, n1, lane)] = entry_;
    if (lane == 0) {
        top = held - nodes + bitCount(n0) + bitCount(n1);
        waiting = left + bitCount(c0) + bitCount(c1);
        if (overflow) full = 1;
    }
}

/* The best of one invocation. */
struct btg_best {
    bool found;
    float value;
    uint cell;
    vec4 place;
};

/* The place (s, t) of a cell; side: its half sides, and those of the grid that would follow. */
void try_sample(btg_gpu_query q, btg_surface_point c, uint cell, vec2 st, vec2 middle, vec4 side,
                bool triangle, inout btg_best best) {
    vec2 uv = middle + st * side.xy;
    if (triangle) {
        uv = hold(uv, true);
        st = (uv - middle) / side.xy;
    }
    btg_ray_hit hit;
    if (!ray_cast(q, taylor(c, st.x, st.y), hit) || hit.value <= q.u.w) return;
    bool better = !best.found || hit.value > best.value ||
                  (hit.value == best.value && cell < best.cell);
    if (!better) return;
    best.found = true;
    best.value = hit.value;
    best.cell = cell;
    best.place = vec4(uv, side.zw);
}

void try_cell(btg_gpu_query q, uint index, float bound, inout btg_best best) {
    uint cell = scene.starts.x + BTG_GPU_CELL * index;
    if (!can_win(q, geometry[cell], bound)) return;
    btg_surface_point c = cell_evaluate(q, cell);
    vec2 middle = vec2(geometry[cell + 2].w, geometry[cell + 3].w);
    vec2 side = vec2(geometry[cell + 4].w, geometry[cell + 5].w);
    uint n = floatBitsToUint(geometry[cell + 6].w);
    bool triangle = floatBitsToUint(geometry[cell + 1].w) >= scene.counts.x;
    float pitch = 2 / float(n - 1);
    for (uint i = 0; i < n; i++)
        for (uint j = 0; j < n; j++)
            try_sample(q, c, cell, vec2(float(i), float(j)) * pitch - 1, middle,
                       vec4(side, side * pitch), triangle, best);
    if (best.found) {
        atomicMax(best_key, key_of(best.value));
        atomicMax(bound_key, key_of(best.value));
    }
    atomicAdd(tried, 1);
}

btg_best walk(btg_gpu_query q) {
    uint lane = gl_LocalInvocationIndex;
    btg_best best;
    best.found = false;
    best.value = 0;
    best.cell = 0xffffffffu;
    best.place = vec4(0);
    if (lane == 0) {
        stack[0] = (scene.counts.y - 1) << 28;
        top = 1;
        waiting = tried = full = 0;
        best_key = bound_key = key_of(q.u.w);
        best_cell = best_index = 0xffffffffu;
    }
    barrier();
    for (uint round = 0; round < ROUNDS; round++) {
        uint held = top, left = waiting;
        /* One bound a round for all: what is left out does not hang on who is quicker. */
        float bound = value_of(bound_key);
        if (lane < 2) node_bits[lane] = cell_bits[lane] = 0;
        barrier();
        if (held == 0 && left == 0) break;
        if (held == 0 || left >= gl_WorkGroupSize.x) {
            uint n = min(left, gl_WorkGroupSize.x);
            if (lane < n) try_cell(q, list[left - n + lane], bound, best);
            if (lane == 0) waiting = left - n;
        } else {
            open_nodes(q, held, left, bound);
        }
        barrier();
    }
    return best;
}

/* The best of all invocations: its place goes to best_place, its cell to best_cell. */
void choose(btg_best best) {
    bool mine = best.found && key_of(best.value) == best_key;
    if (mine) atomicMin(best_cell, best.cell);
    barrier();
    if (mine && best.cell == best_cell) best_place = best.place;
    barrier();
}

/* One grid about the best place, on the expansion c about `middle`. */
void zoom(btg_gpu_query q, btg_surface_point c, vec2 middle, bool triangle) {
    uint lane = gl_LocalInvocationIndex, mine = 0xffffffffu;
    vec4 at = best_place;
    float value = 0;
    vec2 place = at.xy;
    if (lane == 0) {
        best_key = 0;
        best_index = 0xffffffffu;
    }
    barrier();
    for (uint i = lane; i < GRID * GRID; i += gl_WorkGroupSize.x) {
        vec2 st = vec2(i / GRID, i % GRID) * (2.0 / float(GRID - 1)) - 1;
        vec2 uv = hold(at.xy + st * at.zw, triangle), d = uv - middle;
        btg_ray_hit hit;
        if (!ray_cast(q, taylor(c, d.x, d.y), hit)) continue;
        if (mine != 0xffffffffu && hit.value <= value) continue;
        mine = i;
        value = hit.value;
        place = uv;
    }
    if (mine != 0xffffffffu) atomicMax(best_key, key_of(value));
    barrier();
    bool top_value = mine != 0xffffffffu && key_of(value) == best_key;
    if (top_value) atomicMin(best_index, mine);
    barrier();
    if (top_value && mine == best_index) {
        /* On the grid's border, where the item goes on, the top lies further that way. */
        bvec2 border = greaterThanEqual(abs(place - at.xy), 0.99 * at.zw);
        bool grow = border.x || border.y;
        best_place = vec4(place, at.zw * (grow ? 1 : SHRINK));
    }
    barrier();
}

void search(uint index) {
    btg_gpu_query q = queries[index];
    btg_best best = walk(q);
    choose(best);
    uint cell = best_cell;
    bool found = cell != 0xffffffffu;
    btg_item item;
    btg_surface_point c;
    if (found) {
        item = item_of_cell(q, cell);
        for (uint k = 0; k < scene.starts.z; k++) {
            vec2 middle = best_place.xy;
            c = item_evaluate(q, item, middle.x, middle.y);
            for (uint z = 0; z < ZOOM; z++)
                zoom(q, c, middle, item.triangle);
        }
    }
    if (gl_LocalInvocationIndex != 0) return;
    btg_gpu_winner w;
    w.value = w.u = w.v = 0;
    w.item = w.element = w.found = 0;
    w.cells = tried;
    w.full = full;
    btg_ray_hit hit;
    if (found) {
        c = item_evaluate(q, item, best_place.x, best_place.y);
        w.u = best_place.x;
        w.v = best_place.y;
        w.item = item.item;
        if (ray_cast(q, c.s, hit)) {
            w.found = 1;
            w.value = hit.value;
            w.element = hit.element;
        }
    }
    winners[index] = w;
}
