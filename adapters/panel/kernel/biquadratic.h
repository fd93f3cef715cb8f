#pragma once

#include "lanes.h"

// Biquadratic shape functions at the 3 x 3 Gauss points of a cell, one direction after the other
// (sum factorisation: Orszag, J. Comput. Phys. 37 (1980) 70-92, doi:10.1016/0021-9991(80)90005-4).
//
// Nine values of a cell, at its nodes or at its points, stand in the order along, then across.
namespace flipflow {

constexpr double kWeight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

namespace biquadratic {

// The functions of the nodes 0, 1/2, 1 and their slopes at the first point; at the last they are
// mirrored, at the middle one they are 0, 1, 0 and -1, 0, 1.
constexpr double kFirst = 0.5 - 0.5 * 0.77459666924148337704;  // sqrt(3/5)
constexpr double kValue[3] = {(1 - kFirst) * (1 - 2 * kFirst), 4 * kFirst * (1 - kFirst),
                              kFirst *(2 * kFirst - 1)};
constexpr double kSlope[3] = {4 * kFirst - 3, 4 - 8 * kFirst, 4 * kFirst - 1};

// From nodes u[0], u[step], u[2 step] to points at[0], at[step], at[2 step].
template <class V>
FLIPFLOW_INLINE void values(const V *u, V *at, int step) {
  const V a = u[0], b = u[step], c = u[2 * step];
  at[0] = kValue[0] * a + kValue[1] * b + kValue[2] * c;
  at[step] = b;
  at[2 * step] = kValue[2] * a + kValue[1] * b + kValue[0] * c;
}

template <class V>
FLIPFLOW_INLINE void slopes(const V *u, V *at, int step) {
  const V a = u[0], b = u[step], c = u[2 * step];
  at[0] = kSlope[0] * a + kSlope[1] * b + kSlope[2] * c;
  at[step] = c - a;
  at[2 * step] = -kSlope[2] * a - kSlope[1] * b - kSlope[0] * c;
}

// The transposes, added up: from points to nodes.
template <class V>
FLIPFLOW_INLINE void add_values(const V *at, V *u, int step) {
  const V a = at[0], b = at[step], c = at[2 * step];
  u[0] += kValue[0] * a + kValue[2] * c;
  u[step] += kValue[1] * (a + c) + b;
  u[2 * step] += kValue[2] * a + kValue[0] * c;
}

template <class V>
FLIPFLOW_INLINE void add_slopes(const V *at, V *u, int step) {
  const V a = at[0], b = at[step], c = at[2 * step];
  u[0] += kSlope[0] * a - b - kSlope[2] * c;
  u[step] += kSlope[1] * (a - c);
  u[2 * step] += kSlope[2] * a + b - kSlope[0] * c;
}

}  // namespace biquadratic

// Slopes at the points, per cell length and per cell width, of a field given at the nodes.
template <class V>
FLIPFLOW_INLINE void slopes(const V node[9], V along[9], V across[9]) {
  V value[9], slope[9];
  for (int j = 0; j < 3; ++j) {
    biquadratic::values(node + j, value + j, 3);
    biquadratic::slopes(node + j, slope + j, 3);
  }
  for (int i = 0; i < 9; i += 3) {
    biquadratic::values(slope + i, along + i, 1);
    biquadratic::slopes(value + i, across + i, 1);
  }
}

// The transpose: what acts on the slopes at the points, as it acts on the nodes.
template <class V>
FLIPFLOW_INLINE void onto_nodes(const V along[9], const V across[9], V node[9]) {
  V value[9] = {}, slope[9] = {};
  for (int i = 0; i < 9; i += 3) {
    biquadratic::add_values(along + i, slope + i, 1);
    biquadratic::add_slopes(across + i, value + i, 1);
  }
  for (int j = 0; j < 9; ++j) node[j] = V{};
  for (int j = 0; j < 3; ++j) {
    biquadratic::add_values(value + j, node + j, 3);
    biquadratic::add_slopes(slope + j, node + j, 3);
  }
}

}  // namespace flipflow
