#pragma once

#include "lanes.h"

// Mooney-Rivlin in plane stress, incompressible, and the law of a perforated cell
// (docs/theory/panel_sheet.md, perforated_panel.md), of the mid-surface's C.
namespace flipflow {

template <class V>
struct Symmetric {
  V a11, a22, a12;
};

template <class V>
FLIPFLOW_INLINE V det(const Symmetric<V> &C) { return C.a11 * C.a22 - C.a12 * C.a12; }

template <class V>
FLIPFLOW_INLINE Symmetric<V> inverse(const Symmetric<V> &C) {
  const V per_det = 1.0 / det(C);
  return {C.a22 * per_det, C.a11 * per_det, -C.a12 * per_det};
}

// Energy per area, and twice its derivative with respect to C.
template <class V>
FLIPFLOW_INLINE V solid_energy(double c10_N_per_m, double c01_N_per_m, const Symmetric<V> &C) {
  const V trace = C.a11 + C.a22, d = det(C);
  return c10_N_per_m * (trace + 1.0 / d - 3.0) + c01_N_per_m * (d + trace / d - 3.0);
}

template <class V>
FLIPFLOW_INLINE Symmetric<V> solid_stress(double c10_N_per_m, double c01_N_per_m, const Symmetric<V> &C) {
  const V trace = C.a11 + C.a22, d = det(C), per_d = 1.0 / d;
  const V by_trace = 2.0 * (c10_N_per_m + c01_N_per_m * per_d);
  const V by_det = 2.0 * (c01_N_per_m - (c10_N_per_m + c01_N_per_m * trace) * (per_d * per_d));
  return {by_trace + by_det * C.a22, by_trace + by_det * C.a11, -by_det * C.a12};
}

// The strain (C - 1/C) / 4 as a vector (11, 22, twice 12), and `rest` times it.
template <class V>
struct Voigt {
  V h[3], t[3];
};

template <class V>
FLIPFLOW_INLINE Voigt<V> rest_law(const V rest[6], const Symmetric<V> &C, const Symmetric<V> &per_C) {
  Voigt<V> v;
  v.h[0] = 0.25 * (C.a11 - per_C.a11);
  v.h[1] = 0.25 * (C.a22 - per_C.a22);
  v.h[2] = 0.5 * (C.a12 - per_C.a12);
  v.t[0] = rest[0] * v.h[0] + rest[3] * v.h[1] + rest[4] * v.h[2];
  v.t[1] = rest[3] * v.h[0] + rest[1] * v.h[1] + rest[5] * v.h[2];
  v.t[2] = rest[4] * v.h[0] + rest[5] * v.h[1] + rest[2] * v.h[2];
  return v;
}

template <class V>
FLIPFLOW_INLINE V rest_energy(const V rest[6], const Symmetric<V> &C) {
  const Voigt<V> v = rest_law(rest, C, inverse(C));
  return 0.5 * (v.h[0] * v.t[0] + v.h[1] * v.t[1] + v.h[2] * v.t[2]);
}

// (T + C^-1 T C^-1) / 2
template <class V>
FLIPFLOW_INLINE Symmetric<V> rest_stress(const V rest[6], const Symmetric<V> &C) {
  const Symmetric<V> k = inverse(C);
  const Voigt<V> v = rest_law(rest, C, k);
  const V t11 = v.t[0], t22 = v.t[1], t12 = v.t[2];
  const V kt11 = k.a11 * t11 + k.a12 * t12, kt12 = k.a11 * t12 + k.a12 * t22;
  const V kt21 = k.a12 * t11 + k.a22 * t12, kt22 = k.a12 * t12 + k.a22 * t22;
  return {0.5 * (t11 + kt11 * k.a11 + kt12 * k.a12), 0.5 * (t22 + kt21 * k.a12 + kt22 * k.a22),
          0.5 * (t12 + kt11 * k.a12 + kt12 * k.a22)};
}

}  // namespace flipflow
