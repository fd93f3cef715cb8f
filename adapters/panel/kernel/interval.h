#pragma once

#include "lanes.h"

namespace flipflow {

// Motion of held points from the start to the end of an interval, (held, 3) each: cubic Hermite in
// position and velocity, the same formula as HermitePath of orchestrator/ports.
struct HeldPath {
  const double *start_m, *start_m_per_s, *end_m, *end_m_per_s;
  double length_s;

  // Of the number `i` in these arrays, at the fraction `t` of the interval.
  FLIPFLOW_INLINE double position_m(int i, double t) const {
    const double r = 1 - t;
    return (1 + 2 * t) * r * r * start_m[i] + t * r * r * length_s * start_m_per_s[i] +
           t * t * (3 - 2 * t) * end_m[i] - t * t * r * length_s * end_m_per_s[i];
  }

  double velocity_m_per_s(int i, double t) const {
    const double r = 1 - t;
    return 6 * t * r / length_s * (end_m[i] - start_m[i]) + r * (1 - 3 * t) * start_m_per_s[i] +
           t * (3 * t - 2) * end_m_per_s[i];
  }
};

// What a panel meets in an interval: where its clamps come to, and the load on its surface points.
struct PanelInterval {
  const double *clamps_m, *clamps_m_per_s, *load_N;
  double length_s;
  int steps;
};

// Where the motion of a panel's surface points is to be written.
struct PanelSurface {
  double *position_m, *velocity_m_per_s;
};

}  // namespace flipflow
