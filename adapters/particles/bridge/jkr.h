#pragma once

#include <cmath>

namespace flipflow {

// An adhesive elastic contact of two spheres: K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R.
// Soc. Lond. A 324 (1971) 301-313, doi 10.1098/rspa.1971.0141; docs/theory/adhesion.md.
//
// A contact forms at zero overlap and holds, by a neck, down to `separation_m`.  With u^2 = neck /
// (neck when it snaps) and the overlap in units of -separation, the stable branch is the largest
// root u >= 1 of  u^4 - 4 u = 3 overlap,  and the force is pull-off * (u^6 - 6 u^3) / 9.
struct Jkr {
  double e_star_Pa, work_J_per_m2, radius_m;  // reduced modulus, work of adhesion, reduced radius

  double pull_off_N() const { return 1.5 * M_PI * work_J_per_m2 * radius_m; }

  double snapping_neck_m() const {
    return std::cbrt(M_PI * work_J_per_m2 * radius_m * radius_m / (8.0 * e_star_Pa));
  }

  // The overlap, not above zero, at which the neck snaps.
  double separation_m() const {
    const double neck = snapping_neck_m();
    return -3.0 * neck * neck / radius_m;
  }

  // Radius of the contact area; `overlap_m` from `separation_m` up.  The quartic by Ferrari's
  // method: m is the real root of  m^3 + 3 overlap m = 2,  in a form free of cancellation.
  double neck_m(double overlap_m) const {
    if (work_J_per_m2 == 0.0) return std::sqrt(radius_m * overlap_m);
    const double least = snapping_neck_m();
    const double d = std::fmax(overlap_m * radius_m / (3.0 * least * least), -1.0);
    const double t = std::cbrt(1.0 + std::sqrt(1.0 + d * d * d));
    const double m = 2.0 / (t * t + d + d * d / (t * t));
    const double root = std::sqrt(2.0 * m);
    const double u = 0.5 * (root + std::sqrt(std::fmax(8.0 / root - 2.0 * m, 0.0)));
    return least * u * u;
  }

  // The same from the neck of a moment ago, by Newton's iteration on its square root s, of which
  // overlap = s^4 / radius - s pull, pull^2 = 2 pi work / e_star.  It takes no cube root, and goes on until
  // the next step would be below rounding; where it does not get there, Ferrari's method answers.
  double neck_m(double overlap_m, double last_neck_m) const {
    constexpr double kRounding = 1e-16;
    constexpr int kIterations = 8;  // two or three are usual
    if (work_J_per_m2 == 0.0 || last_neck_m <= 0.0) return neck_m(overlap_m);
    const double pull = std::sqrt(2.0 * M_PI * work_J_per_m2 / e_star_Pa), per_m = 1.0 / radius_m;
    double s = std::sqrt(last_neck_m);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      const double cube = s * s * s * per_m, slope = 4.0 * cube - pull;
      if (slope <= 0.0) break;  // beyond where the neck snaps
      const double step = (s * (cube - pull) - overlap_m) / slope;
      s -= step;
      if (6.0 * s * per_m * step * step <= kRounding * slope) return s * s;
    }
    return neck_m(overlap_m);
  }

  // Does a neck hold at this overlap: is it no deeper below zero than `separation_m`?
  bool holds(double overlap_m) const {
    const double pull2 = 2.0 * M_PI * work_J_per_m2 / e_star_Pa;
    return 256.0 * -overlap_m * overlap_m * overlap_m <= 27.0 * pull2 * pull2 * radius_m;
  }

  // Positive pushes the spheres apart.
  double force_N(double neck_m) const {
    const double cube = neck_m * neck_m * neck_m;
    return 4.0 / 3.0 * e_star_Pa * cube / radius_m -
           std::sqrt(8.0 * M_PI * work_J_per_m2 * e_star_Pa * cube);
  }

  double elastic_J(double neck_m, double overlap_m) const {
    const double flat = neck_m * neck_m / radius_m;
    return e_star_Pa * neck_m *
           (overlap_m * overlap_m - 2.0 / 3.0 * flat * overlap_m + 0.2 * flat * flat);
  }

  double adhesion_J(double neck_m) const { return -M_PI * neck_m * neck_m * work_J_per_m2; }
};

}  // namespace flipflow
