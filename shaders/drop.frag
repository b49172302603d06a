#version 450
#extension GL_GOOGLE_include_directive : require
/* DROP: a pixel of a tile. */
#include "raster.glsl"
