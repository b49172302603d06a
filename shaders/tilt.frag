#version 450
#extension GL_GOOGLE_include_directive : require
/* TILT: a pixel of a tile. */
#define BTG_TILT
#include "raster.glsl"
