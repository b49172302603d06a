#version 450
#extension GL_GOOGLE_include_directive : require
/* The least depth of each tile and where, by one workgroup; then further valleys that may be as low
 * between the pixels, or where on the rim a valley may leave the tile. */
#include "tiles.h"

/* Few lanes are quickest on small tiles; large ones get more (raster.c): llvmpipe ends a shader that
 * has gone round its loops 65535 times, and says nothing. */
layout(local_size_x_id = 0, local_size_y = 1, local_size_z = 1) in;
layout(location = 0, binding = 0) uniform sampler2D depths;
layout(location = 1, binding = 1) uniform usampler2D places;
layout(std140, binding = BTG_RASTER_PASS) uniform pass_block {
    btg_raster_pass pass;
};
layout(std430, binding = BTG_RASTER_TILES) readonly buffer tile_block {
    btg_raster_tile tiles[];
};
layout(std430, binding = BTG_RASTER_PICKS) writeonly buffer pick_block {
    btg_raster_pick picks[];
};

const uint NONE = 0xffffffffu;
const float NOTHING = 1;
/* Valleys are at least that many pixels apart. */
const int APART = 1;

/* Valleys that are looked at. */
const uint VALLEYS = 256;

shared uint best_depth, best_pixel, count;
shared uint valleys[VALLEYS];

ivec2 first;
int size;

ivec2 pixel_at(uint i) {
    return ivec2(i % uint(size), i / uint(size));
}

uint index_of(ivec2 p) {
    return uint(p.y * size + p.x);
}

/* A lane's next pixel, without a division. */
ivec2 next(ivec2 p, ivec2 stride) {
    p += stride;
    return p.x < size ? p : ivec2(p.x - size, p.y + 1);
}

float depth_at(ivec2 p) {
    return texelFetch(depths, first + p, 0).x;
}

/* No pixel about it is lower; of equal ones the first. */
bool valley(ivec2 p, float depth) {
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            ivec2 n = p + ivec2(i, j);
            if (any(lessThan(n, ivec2(0))) || any(greaterThanEqual(n, ivec2(size)))) continue;
            float other = depth_at(n);
            bool before = j < 0 || (j == 0 && i < 0);
            if (other < depth || (before && other == depth)) return false;
        }
    return true;
}

/* The least depth of all. */
float find_best() {
    uint lane = gl_LocalInvocationIndex, at = NONE;
    float mine = NOTHING;
    if (lane == 0) {
        best_depth = best_pixel = NONE;
        count = 0;
    }
    barrier();
    ivec2 p = pixel_at(lane), stride = pixel_at(gl_WorkGroupSize.x);
    for (; p.y < size; p = next(p, stride)) {
        float depth = depth_at(p);
        if (depth >= mine) continue;
        mine = depth;
        at = index_of(p);
    }
    if (at != NONE) atomicMin(best_depth, floatBitsToUint(mine));
    barrier();
    if (at != NONE && floatBitsToUint(mine) == best_depth) atomicMin(best_pixel, at);
    barrier();
    return best_pixel == NONE ? NOTHING : uintBitsToFloat(best_depth);
}

void find_valleys(float most) {
    ivec2 p = pixel_at(gl_LocalInvocationIndex), stride = pixel_at(gl_WorkGroupSize.x);
    for (; p.y < size; p = next(p, stride)) {
        float depth = depth_at(p);
        if (depth > most || depth >= NOTHING || !valley(p, depth)) continue;
        uint n = atomicAdd(count, 1);
        if (n < VALLEYS) valleys[n] = index_of(p);
    }
    barrier();
}

/* Pixels of the rim, round about. */
ivec2 rim_at(uint i) {
    int last = size - 1, k = int(i) % last;
    switch (int(i) / last % 4) {
    case 0: return ivec2(k, 0);
    case 1: return ivec2(last, k);
    case 2: return ivec2(last - k, last);
    default: return ivec2(0, last - k);
    }
}

/* Where the rim is as low between its neighbours: there a valley may go on. */
void find_rim(float most) {
    uint around = uint(4 * (size - 1));
    for (uint i = gl_LocalInvocationIndex; i < around; i += gl_WorkGroupSize.x) {
        ivec2 p = rim_at(i);
        float depth = depth_at(p);
        if (depth > most || depth >= NOTHING) continue;
        if (depth >= depth_at(rim_at(i + around - 1)) || depth > depth_at(rim_at(i + 1))) continue;
        uint n = atomicAdd(count, 1);
        if (n < VALLEYS) valleys[n] = index_of(p);
    }
    barrier();
}

/* The lowest of those found that is not near one of the chosen from `from` to k - 1: NONE. */
uint choose(uint chosen[BTG_RASTER_PICKS_MAX], uint from, uint k) {
    uint best = NONE;
    float least = NOTHING;
    for (uint n = 0; n < min(count, VALLEYS); n++) {
        ivec2 p = pixel_at(valleys[n]);
        bool near = false;
        for (uint i = from; i < k; i++) {
            ivec2 d = abs(p - pixel_at(chosen[i]));
            near = near || max(d.x, d.y) <= APART;
        }
        float depth = depth_at(p);
        if (near || depth > least || (depth == least && valleys[n] > best)) continue;
        least = depth;
        best = valleys[n];
    }
    return best;
}

btg_raster_pick pick_at(uint pixel) {
    if (pixel == NONE) return btg_raster_pick(NOTHING, 0, 0, NONE);
    ivec2 p = pixel_at(pixel);
    uvec2 found = texelFetch(places, first + p, 0).xy;
    return btg_raster_pick(depth_at(p), found.x, found.y, pixel);
}

void main() {
    uint tile = gl_WorkGroupID.x, wanted = pass.size.y, chosen[BTG_RASTER_PICKS_MAX];
    size = int(pass.size.x);
    first = ivec2(tiles[tile].at.zw);
    float least = find_best();
    bool rim = pass.size.w != 0;
    float most = least + pass.scale.z * tiles[tile].limits.w;
    if (wanted > 1 && least < NOTHING) {
        if (rim)
            find_rim(most);
        else
            find_valleys(most);
    }
    if (gl_LocalInvocationIndex != 0) return;
    chosen[0] = best_pixel;
    for (uint k = 0; k < wanted; k++) {
        if (k > 0) chosen[k] = choose(chosen, rim ? 1 : 0, k);
        picks[tile * wanted + k] = pick_at(chosen[k]);
    }
}
