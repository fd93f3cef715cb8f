#pragma once

#include "vec3.h"

namespace flipflow {

// Three points that move evenly from `before` to `now`.
struct MovingTriangle {
  Vec3 before[3], now[3];
};

// Does a point that moves evenly from `before` to `now` go through the triangle on its way: does it
// end on the other side of the triangle's plane, and was it inside of the triangle when it changed
// sides?  A point in the plane counts to its back; one on an edge goes through both triangles there.
bool goes_through(Vec3 before, Vec3 now, const MovingTriangle &triangle);

}  // namespace flipflow
