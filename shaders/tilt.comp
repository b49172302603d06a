#version 430
#extension GL_GOOGLE_include_directive : require
/* TILT for a batch: one workgroup a query. */
#define BTG_TILT
#include "buffers.glsl"
#include "surface.glsl"
#include "ray.glsl"
#include "search.glsl"

void main() {
    search(gl_WorkGroupID.x);
}
