#pragma once

#include <algorithm>
#include <vector>

#include "biquadratic.h"
#include "lanes.h"
#include "maxwell.h"
#include "node_places.h"

namespace flipflow {

// What a cell is made of, in N/m: Mooney-Rivlin constants times thickness, of which a cell has the
// share `solid` (cells); on top the quadratic law `rest` (cells, 6: 11, 22, 33, 12, 13, 23) in the
// strain (C - 1/C) / 4, if any cell has it; `strain` (cells, 5) makes the scaled strain of the
// branches from E: (s0 E11 + s1 E22, s2 E11 + s3 E22, s4 2 E12).
struct MembraneLaw {
  double c10_N_per_m, c01_N_per_m;
  std::vector<double> solid, rest, strain;
};

// Places of cells side by side (node_places.h).  Where there is no cell, all but `missing` is zero: what
// is read there counts for an unstrained cell, and gives no force.
struct alignas(kLanes * sizeof(double)) CellGroup {
  double per_s2[kLanes], per_sy[kLanes], per_y2[kLanes];  // 1 / (products of two cell lengths)
  double area[kLanes], solid[kLanes], rest[6][kLanes], strain[5][kLanes], missing[kLanes];
};

// Mooney-Rivlin in plane stress, incompressible, and the law of a perforated cell
// (docs/theory/panel_sheet.md, perforated_panel.md), of the mid-surface's C.

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

// What cells do to their nodes, by the cells' places: (9 nodes, 3, row).
struct CellForces {
  const double *all_N;
  int row;
  int by_node[9];     // where the forces on each node of a cell begin
  int on_kind[4][4];  // for each kind of nodes, where those to add up begin, as seen from the node's place

  // The force on the component `c` of nodes of a kind, those at `place` and behind it: of the four cells
  // around a corner, of two at an edge, of one around a centre.
  template <class V, int kind>
  FLIPFLOW_INLINE V on(int c, int place) const {
    constexpr int cells = kind == 0 ? 4 : kind == 3 ? 1 : 2;
    const double *const component_N = all_N + c * row + place;
    V sum = load<V>(component_N + on_kind[kind][0]);
    for (int i = 1; i < cells; ++i) sum += load<V>(component_N + on_kind[kind][i]);
    return sum;
  }
};

// Force and energy of the membrane (adapters/panel/finite_element/sheet_forms.py, perforation.py), kWidth<V>
// places of cells at a time.
class Membrane {
 public:
  Membrane(const CellGrid &grid, const MembraneLaw &law)
      : places_(grid),
        groups_(places_.groups()),
        forces_{nullptr, places_.margin() + places_.row(), {}, {}},
        force_N_(9 * 3 * forces_.row),
        c10_N_per_m_(law.c10_N_per_m),
        c01_N_per_m_(law.c01_N_per_m),
        perforated_(!law.rest.empty()) {
    for (CellGroup &group : groups_) std::fill_n(group.missing, kLanes, 1.0);
    for (int cell = 0; cell < grid.cells(); ++cell) {
      const double s = grid.along_m[cell / grid.across()], y = grid.across_m[cell % grid.across()];
      const int place = places_.of_cell(cell), lane = place % kLanes;
      CellGroup &group = groups_[place / kLanes];
      group.per_s2[lane] = 1.0 / (s * s);
      group.per_sy[lane] = 1.0 / (s * y);
      group.per_y2[lane] = 1.0 / (y * y);
      group.area[lane] = s * y;
      group.missing[lane] = 0.0;
      for (int k = 0; k < 5; ++k) group.strain[k][lane] = law.strain[5 * cell + k];
      group.solid[lane] = law.solid[cell];
      for (int k = 0; k < 6; ++k) group.rest[k][lane] = perforated_ ? law.rest[6 * cell + k] : 0.0;
    }
    int met[4] = {};
    for (int k = 0; k < 9; ++k) {
      const int kind = places_.kind(k), shift = places_.shift(k);
      place_[k] = places_.row_start(kind) + shift;
      forces_.by_node[k] = 3 * k * forces_.row + places_.margin();
      forces_.on_kind[kind][met[kind]++] = forces_.by_node[k] - shift;
    }
  }

  int groups() const { return static_cast<int>(groups_.size()); }

  // Finds the forces of the cells at `position_m` (3, places), and carries the scaled strain
  // (groups, 9, 3, kLanes) and the branches' stresses (groups, 9, branches, 3, kLanes) there.
  template <class V>
  FLIPFLOW_INLINE void step(const Branches &branches, const double *position_m, double *strain,
                            double *stress, StepWork &work) {
    const Step step = {branches, position_m, strain, stress, work.cross_J.data(), work.square_J};
    if (perforated_)
      branches.count() ? step_all<V, true, true>(step) : step_all<V, true, false>(step);
    else
      branches.count() ? step_all<V, false, true>(step) : step_all<V, false, false>(step);
  }

  CellForces forces() const {
    CellForces here = forces_;
    here.all_N = force_N_.data();
    return here;
  }

  double energy_J(const double *position_m) const {
    Two total{};
    for (int n = 0; n < groups() * kLanes; n += kWidth<Two>) {
      Cells<Two> cells(groups_[n / kLanes], n % kLanes);
      gather(position_m, n, cells);
      Two rest[6];
      for (int k = 0; k < 6; ++k) rest[k] = cells.get(cells.group.rest[k]);
      for (int point = 0; point < 9; ++point) {
        const Symmetric<Two> C = cells.metric(point);
        Two density = cells.get(cells.group.solid) * solid_energy(c10_N_per_m_, c01_N_per_m_, C);
        if (perforated_) density += rest_energy(rest, C);
        total += cells.area(point) * density;
      }
    }
    return total[0] + total[1];
  }

 private:
  // What a step works on; `cross_J` (branches, kLanes) and `square_J` (kLanes) are added to.
  struct Step {
    const Branches &branches;
    const double *position_m;
    double *strain, *stress, *cross_J, *square_J;
  };

  // Where in a group the cells stand that are at hand, and the slopes of their position at the
  // points, per cell length and width.
  template <class V>
  struct Cells {
    const CellGroup &group;
    int lane;
    V along[3][9], across[3][9];

    Cells(const CellGroup &of, int at) : group(of), lane(at) {}  // to fill in zeros first takes a while

    FLIPFLOW_INLINE V get(const double *of_group) const { return load<V>(of_group + lane); }

    // The mid-surface's C at a point.
    FLIPFLOW_INLINE Symmetric<V> metric(int point) const {
      V ss{}, sy{}, yy{};
      for (int c = 0; c < 3; ++c) {
        const V s = along[c][point], y = across[c][point];
        ss += s * s;
        sy += s * y;
        yy += y * y;
      }
      const V missing = get(group.missing);
      return {get(group.per_s2) * ss + missing, get(group.per_y2) * yy + missing, get(group.per_sy) * sy};
    }

    FLIPFLOW_INLINE V area(int point) const {
      return kWeight[point / 3] * kWeight[point % 3] * get(group.area);
    }

    // Puts the stress on the slopes at a point, S times them, in their place.
    FLIPFLOW_INLINE void press(const Symmetric<V> &S, V area, int point) {
      const V s11 = area * get(group.per_s2) * S.a11;
      const V s22 = area * get(group.per_y2) * S.a22;
      const V s12 = area * get(group.per_sy) * S.a12;
      for (int c = 0; c < 3; ++c) {
        const V s = along[c][point], y = across[c][point];
        along[c][point] = s * s11 + y * s12;
        across[c][point] = s * s12 + y * s22;
      }
    }
  };

  template <class V>
  FLIPFLOW_INLINE void gather(const double *position_m, int place, Cells<V> &cells) const {
    for (int c = 0; c < 3; ++c) {
      V node[9];
      for (int k = 0; k < 9; ++k)
        node[k] = load<V>(position_m + c * places_.size() + place + place_[k]);
      slopes(node, cells.along[c], cells.across[c]);
    }
  }

  // Of what stands in place of the slopes: the stress on them.
  template <class V>
  FLIPFLOW_INLINE void scatter(const Cells<V> &cells, int place) {
    for (int c = 0; c < 3; ++c) {
      V node[9];
      onto_nodes(cells.along[c], cells.across[c], node);
      double *const component_N = force_N_.data() + c * forces_.row + place;
      for (int k = 0; k < 9; ++k) store(component_N + forces_.by_node[k], node[k]);
    }
  }

  // The branches' overstress at a point, as a stress that works on E; carries strain and stress.
  template <class V>
  FLIPFLOW_INLINE Symmetric<V> overstress(const Step &step, const Cells<V> &cells,
                                          const Symmetric<V> &C, V area, double *strain,
                                          double *stress) const {
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
    add_to(step.square_J + cells.lane, area * square);
    for (int b = 0; b < step.branches.count(); ++b, stress += 3 * kLanes) {
      const double ratio = step.branches.ratio()[b], decay = step.branches.decay()[b];
      const double gain = step.branches.gain()[b];
      V cross{};
      for (int k = 0; k < 3; ++k) {
        const V old = load<V>(stress + k * kLanes), next = decay * old + gain * change[k];
        cross += old * change[k];
        over[k] += ratio * next;
        store(stress + k * kLanes, next);
      }
      add_to(step.cross_J + b * kLanes + cells.lane, area * cross);
    }
    return {s0 * over[0] + s2 * over[1], s1 * over[0] + s3 * over[1], s4 * over[2]};
  }

  template <class V, bool perforated>
  FLIPFLOW_INLINE Symmetric<V> elastic_stress(const Cells<V> &cells, const Symmetric<V> &C) const {
    Symmetric<V> S = solid_stress(c10_N_per_m_, c01_N_per_m_, C);
    if (!perforated) return S;
    V rest[6];
    for (int k = 0; k < 6; ++k) rest[k] = cells.get(cells.group.rest[k]);
    const Symmetric<V> more = rest_stress(rest, C);
    const V solid = cells.get(cells.group.solid);
    return {solid * S.a11 + more.a11, solid * S.a22 + more.a22, solid * S.a12 + more.a12};
  }

  template <class V, bool perforated, bool relaxes>
  FLIPFLOW_INLINE void step_cells(const Step &step, int group, int lane) {
    Cells<V> cells(groups_[group], lane);
    gather(step.position_m, group * kLanes + lane, cells);
    const int branches = step.branches.count();
    for (int point = 0; point < 9; ++point) {
      const Symmetric<V> C = cells.metric(point);
      const V area = cells.area(point);
      Symmetric<V> S = elastic_stress<V, perforated>(cells, C);
      if (relaxes) {
        const size_t at = (9 * group + point) * 3 * kLanes;
        const Symmetric<V> over = overstress(step, cells, C, area, step.strain + at + lane,
                                             step.stress + branches * at + lane);
        S = {S.a11 + over.a11, S.a22 + over.a22, S.a12 + over.a12};
      }
      cells.press(S, area, point);
    }
    scatter(cells, group * kLanes + lane);
  }

  template <class V, bool perforated, bool relaxes>
  FLIPFLOW_INLINE void step_all(const Step &step) {
    for (int group = 0; group < groups(); ++group)
      for (int lane = 0; lane < kLanes; lane += kWidth<V>)
        step_cells<V, perforated, relaxes>(step, group, lane);
  }

  NodePlaces places_;
  std::vector<CellGroup> groups_;
  CellForces forces_;
  Numbers force_N_;
  double c10_N_per_m_, c01_N_per_m_;
  bool perforated_;
  int place_[9];  // of a cell's nodes, from the cell's own
};

}  // namespace flipflow
