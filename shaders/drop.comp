#version 430
#extension GL_GOOGLE_include_directive : require
/* DROP for a batch: one workgroup a query. */
#include "buffers.glsl"
#include "surface.glsl"
#include "ray.glsl"
#include "search.glsl"

void main() {
    search(gl_WorkGroupID.x);
}
