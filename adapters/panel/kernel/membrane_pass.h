#pragma once

#include "biquadratic.h"
#include "maxwell.h"
#include "membrane.h"
#include "membrane_law.h"

// The loops over cells and Gauss points behind Membrane, kWidth<V> cells at a time.
namespace flipflow {

// Where in a group the cells stand that are at hand, and the slopes of their position at the
// points, per cell length and width.
template <class V>
struct Cells {
  const CellGroup &group;
  int lane;
  V along[3][9], across[3][9];

  FLIPFLOW_INLINE V get(const double *of_group) const { return load<V>(of_group + lane); }
};

template <class V>
FLIPFLOW_INLINE void gather(int nodes_across, const double *position_m, Cells<V> &cells) {
  for (int c = 0; c < 3; ++c) {
    V node[9];
    for (int k = 0; k < 9; ++k)
      for (int i = 0; i < kWidth<V>; ++i)
        node[k][i] = position_m[3 * (cells.group.corner[cells.lane + i] + k / 3 * nodes_across +
                                     k % 3) + c];
    slopes(node, cells.along[c], cells.across[c]);
  }
}

// Of what stands in place of the slopes: the stress on them.
template <class V>
FLIPFLOW_INLINE void scatter(const Cells<V> &cells, int nodes_across, double *force_N) {
  for (int c = 0; c < 3; ++c) {
    V node[9];
    onto_nodes(cells.along[c], cells.across[c], node);
    for (int k = 0; k < 9; ++k)
      for (int i = 0; i < kWidth<V>; ++i)
        force_N[3 * (cells.group.corner[cells.lane + i] + k / 3 * nodes_across + k % 3) + c] +=
            node[k][i];
  }
}

template <class V>
FLIPFLOW_INLINE Symmetric<V> metric(const Cells<V> &cells, int point) {
  V ss{}, sy{}, yy{};
  for (int c = 0; c < 3; ++c) {
    const V s = cells.along[c][point], y = cells.across[c][point];
    ss += s * s;
    sy += s * y;
    yy += y * y;
  }
  const CellGroup &group = cells.group;
  return {cells.get(group.per_s2) * ss, cells.get(group.per_y2) * yy, cells.get(group.per_sy) * sy};
}

template <class V>
FLIPFLOW_INLINE V area_of(const Cells<V> &cells, int point) {
  return kWeight[point / 3] * kWeight[point % 3] * cells.get(cells.group.area);
}

// The branches' overstress at a point, as a stress that works on E; carries strain and stress.
template <class V>
FLIPFLOW_INLINE Symmetric<V> overstress(const MembranePass &pass, const Cells<V> &cells,
                                        const Symmetric<V> &C, V area, double *strain,
                                        double *stress) {
  const auto entry = cells.group.strain;
  const V s0 = cells.get(entry[0]), s1 = cells.get(entry[1]), s2 = cells.get(entry[2]);
  const V s3 = cells.get(entry[3]), s4 = cells.get(entry[4]);
  const V e11 = 0.5 * (C.a11 - 1.0), e22 = 0.5 * (C.a22 - 1.0);
  const V now[3] = {s0 * e11 + s1 * e22, s2 * e11 + s3 * e22, s4 * C.a12};
  V change[3], over[3] = {}, square{};
  for (int k = 0; k < 3; ++k) {
    change[k] = now[k] - load<V>(strain + k * kLanes);
    store(strain + k * kLanes, now[k]);
    square += change[k] * change[k];
  }
  add_to(pass.square_J + cells.lane, area * square);
  for (int b = 0; b < pass.branches->count(); ++b, stress += 3 * kLanes) {
    const double ratio = pass.branches->ratio()[b], decay = pass.branches->decay()[b];
    const double gain = pass.branches->gain()[b];
    V cross{};
    for (int k = 0; k < 3; ++k) {
      const V old = load<V>(stress + k * kLanes), next = decay * old + gain * change[k];
      cross += old * change[k];
      over[k] += ratio * next;
      store(stress + k * kLanes, next);
    }
    add_to(pass.cross_J + b * kLanes + cells.lane, area * cross);
  }
  return {s0 * over[0] + s2 * over[1], s1 * over[0] + s3 * over[1], s4 * over[2]};
}

template <class V, bool perforated>
FLIPFLOW_INLINE Symmetric<V> elastic_stress(const MembranePass &pass, const Cells<V> &cells,
                                            const Symmetric<V> &C) {
  Symmetric<V> S = solid_stress(pass.c10_N_per_m, pass.c01_N_per_m, C);
  if (!perforated) return S;
  V rest[6];
  for (int k = 0; k < 6; ++k) rest[k] = cells.get(cells.group.rest[k]);
  const Symmetric<V> more = rest_stress(rest, C);
  const V solid = cells.get(cells.group.solid);
  return {solid * S.a11 + more.a11, solid * S.a22 + more.a22, solid * S.a12 + more.a12};
}

// Puts the stress on the slopes at a point, S times them, in their place.
template <class V>
FLIPFLOW_INLINE void press(const Symmetric<V> &S, V area, int point, Cells<V> &cells) {
  const CellGroup &group = cells.group;
  const V s11 = area * cells.get(group.per_s2) * S.a11;
  const V s22 = area * cells.get(group.per_y2) * S.a22;
  const V s12 = area * cells.get(group.per_sy) * S.a12;
  for (int c = 0; c < 3; ++c) {
    const V s = cells.along[c][point], y = cells.across[c][point];
    cells.along[c][point] = s * s11 + y * s12;
    cells.across[c][point] = s * s12 + y * s22;
  }
}

template <class V, bool perforated>
FLIPFLOW_INLINE void step_cells(const MembranePass &pass, int group, int lane) {
  Cells<V> cells = {pass.group[group], lane, {}, {}};
  gather(pass.nodes_across, pass.position_m, cells);
  const int branches = pass.branches->count();
  for (int point = 0; point < 9; ++point) {
    const Symmetric<V> C = metric(cells, point);
    const V area = area_of(cells, point);
    Symmetric<V> S = elastic_stress<V, perforated>(pass, cells, C);
    if (branches > 0) {
      const size_t at = (9 * group + point) * 3 * kLanes;
      const Symmetric<V> over = overstress(pass, cells, C, area, pass.strain + at + lane,
                                           pass.stress + branches * at + lane);
      S = {S.a11 + over.a11, S.a22 + over.a22, S.a12 + over.a12};
    }
    press(S, area, point, cells);
  }
  scatter(cells, pass.nodes_across, pass.force_N);
}

template <class V>
FLIPFLOW_INLINE void step_all(const MembranePass &pass) {
  for (int group = 0; group < pass.groups; ++group)
    for (int lane = 0; lane < kLanes; lane += kWidth<V>)
      pass.perforated ? step_cells<V, true>(pass, group, lane)
                      : step_cells<V, false>(pass, group, lane);
}

template <class V>
FLIPFLOW_INLINE double energy_all(const MembranePass &pass) {
  V total{};
  for (int n = 0; n < pass.groups * kLanes; n += kWidth<V>) {
    Cells<V> cells = {pass.group[n / kLanes], n % kLanes, {}, {}};
    gather(pass.nodes_across, pass.position_m, cells);
    V rest[6];
    for (int k = 0; k < 6; ++k) rest[k] = cells.get(cells.group.rest[k]);
    for (int point = 0; point < 9; ++point) {
      const Symmetric<V> C = metric(cells, point);
      V density = cells.get(cells.group.solid) * solid_energy(pass.c10_N_per_m, pass.c01_N_per_m, C);
      if (pass.perforated) density += rest_energy(rest, C);
      total += area_of(cells, point) * density;
    }
  }
  double energy_J = 0.0;
  for (int i = 0; i < kWidth<V>; ++i) energy_J += total[i];
  return energy_J;
}

}  // namespace flipflow
