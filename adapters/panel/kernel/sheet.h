#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bending.h"
#include "interval.h"
#include "lanes.h"
#include "maxwell.h"
#include "membrane.h"
#include "node_places.h"

namespace flipflow {

// All that changes while a sheet moves; arrays that Python owns.  (3, places) each, and the
// parts' strains, elastic forces and stresses as in membrane.h and bending.h; `energy_J` (2,
// branches) of the membrane's and of bending's branches, `lost_J` (1) since the start, `received_J`
// (2) from the load and from the clamps.
struct SheetState {
  double *position_m, *velocity_m_per_s, *internal_N;
  double *strain, *strain_stress, *elastic_N, *bending_stress_N;
  double *energy_J, *lost_J, *received_J;
};

// The largest size of a number, or NaN if one of them is not finite.
inline double largest_size(const double *numbers, int size) {
  double largest = 0.0, zero = 0.0;
#pragma omp simd reduction(max : largest) reduction(+ : zero)
  for (int i = 0; i < size; ++i) {
    const double number = std::abs(numbers[i]);
    largest = number > largest ? number : largest;
    zero += 0.0 * number;
  }
  return largest + zero;
}

// What the nodes of a sheet are: `mobility_1_kg` and `mass_kg` (nodes), `weight_N` and the positions
// without bending, `flat_m`, (nodes, 3).  The motion of those `held`, of no mobility, is prescribed.
// Those `joined` two by two, of equal mobility, move alike.
struct SheetNodes {
  std::vector<double> mobility_1_kg, mass_kg, weight_N, flat_m;
  std::vector<int> held, joined;
};

// A thin sheet in velocity Verlet: Explicit of adapters/panel/finite_element/integrators.py on the
// structure of sheet_forms.py.
class Sheet {
 public:
  Sheet(const CellGrid &grid, const MembraneLaw &law, const MatrixEntries &bending, Branches branches,
        SheetNodes nodes)
      : places_(grid),
        membrane_(grid, law),
        bending_(places_, bending),
        branches_(std::move(branches)),
        nodes_(std::move(nodes)),
        held_at_(3 * nodes_.held.size()),
        place_(grid.nodes()),
        mobility_1_kg_(places_.size()),
        flat_m_(size()),
        outside_N_(size()),
        bent_m_(size()),
        moved_m_(size()),
        before_m_(held_at_.size()),
        before_N_(held_at_.size()) {
    for (int node = 0; node < grid.nodes(); ++node) {
      place_[node] = places_.of_node(node);
      mobility_1_kg_.data()[place_[node]] = nodes_.mobility_1_kg[node];
      for (int c = 0; c < 3; ++c) flat_m_.data()[at(node, c)] = nodes_.flat_m[3 * node + c];
    }
    for (int i = 0; i < 3 * held(); ++i) held_at_[i] = at(nodes_.held[i / 3], i % 3);
  }

  double membrane_J(const double *position_m) const { return membrane_.energy_J(position_m); }
  int size() const { return 3 * places_.size(); }
  int points() const { return static_cast<int>(place_.size()); }
  int held() const { return static_cast<int>(nodes_.held.size()); }
  int clamp_points() const { return held(); }
  int surface_points() const { return points(); }

  // Takes the positions as the shape in which every branch is relaxed.
  void rest(const SheetState &state) {
    branches_.set_relaxed();
    std::fill_n(moved_m_.data(), size(), 0.0);
    for (int i = 0; i < size(); ++i) bent_m_.data()[i] = state.position_m[i] - flat_m_.data()[i];
    find_force(state);
    std::fill_n(state.energy_J, 2 * branches_.count(), 0.0);
    state.lost_J[0] = 0.0;
  }

  // Moves the state in `steps` steps under a constant force (nodes, 3).  Adds the internal force's
  // impulse (held, 3) and returns its work at the held nodes.
  double advance(const SheetState &state, const HeldPath &path, const double *outside_N,
                 int steps, double *impulse_N_s) {
    const double step_s = path.length_s / steps;
    branches_.set_step(step_s);
    for (int node = 0; node < points(); ++node)
      for (int c = 0; c < 3; ++c) outside_N_.data()[at(node, c)] = outside_N[3 * node + c];
    join(outside_N_.data());
    double work_J = 0.0;
    for (int step = 1; step <= steps; ++step) {
      for (int i = 0; i < 3 * held(); ++i) {
        before_m_[i] = state.position_m[held_at_[i]];
        before_N_[i] = state.internal_N[held_at_[i]];
      }
      // half a step of force before the first step and after the last, a whole one between two
      const double kick_s = step == 1 ? 0.5 * step_s : step_s;
      drift(kick_s, step_s, state);
      place_held(state, path, static_cast<double>(step) / steps);
      const Works works = find_force(state);
      state.lost_J[0] += branches_.book(works.stretching, state.energy_J);
      state.lost_J[0] += branches_.book(works.bending, state.energy_J + branches_.count());
      work_J += collect(state, step_s, impulse_N_s);
    }
    kick(places_.size(), 0.5 * step_s, mobility_1_kg_.data(), outside_N_.data(), state);
    return work_J;
  }

  // Moves the state over an interval, as ElasticPanel of adapters/panel/finite_element/elastic_panel.py
  // does: its clamps go on from the held nodes, which they have moved.  Fills in the surface's motion
  // (nodes, 3) at the end and the mean force on the clamps (held, 3), adds the work of the load and of
  // the clamps to the state's books, and returns the largest speed of a node.
  double pass(const SheetState &state, const PanelInterval &now, const PanelSurface &surface,
              double *reaction_N) {
    const int numbers = 3 * points();
    std::vector<double> start_m(3 * held()), start_m_per_s(3 * held()), impulse_N_s(3 * held());
    std::vector<double> outside_N(numbers), start_surface_m(numbers);
    for (int i = 0; i < numbers; ++i) outside_N[i] = nodes_.weight_N[i] + now.load_N[i];
    by_nodes(state.position_m, start_surface_m.data());
    for (int i = 0; i < 3 * held(); ++i) {
      start_m[i] = state.position_m[held_at_[i]];
      start_m_per_s[i] = state.velocity_m_per_s[held_at_[i]];
    }
    const HeldPath path = {start_m.data(), start_m_per_s.data(), now.clamps_m, now.clamps_m_per_s,
                           now.length_s};
    double clamps_J = advance(state, path, outside_N.data(), now.steps, impulse_N_s.data()), load_J = 0.0;
    for (int i = 0; i < 3 * held(); ++i) {
      const int node = nodes_.held[i / 3];
      const double before = start_m_per_s[i], after = state.velocity_m_per_s[held_at_[i]];
      const double gained_N_s = nodes_.mass_kg[node] * (after - before);
      const double on_clamp_N = outside_N[3 * node + i % 3];
      clamps_J += 0.5 * gained_N_s * (after + before);
      clamps_J -= on_clamp_N * (state.position_m[held_at_[i]] - start_m[i]);
      reaction_N[i] = on_clamp_N - (gained_N_s + impulse_N_s[i]) / now.length_s;
    }
    by_nodes(state.position_m, surface.position_m);
    by_nodes(state.velocity_m_per_s, surface.velocity_m_per_s);
    for (int i = 0; i < numbers; ++i) load_J += now.load_N[i] * (surface.position_m[i] - start_surface_m[i]);
    state.received_J[0] += load_J;
    state.received_J[1] += clamps_J;
    return largest_size(surface.velocity_m_per_s, numbers);
  }

 private:
  // Where the component `c` of a node stands in (3, places).
  int at(int node, int c) const { return c * places_.size() + place_[node]; }

  // From (3, places) to (nodes, 3).
  void by_nodes(const double *by_places, double *values) const {
    for (int node = 0; node < points(); ++node)
      for (int c = 0; c < 3; ++c) values[3 * node + c] = by_places[at(node, c)];
  }

  struct Works {
    StepWork stretching, bending;
  };

  // What a force does to the free nodes in this time.
  FLIPFLOW_CLONES
  static void kick(int places, double kick_s, const double *mobility_1_kg, const double *outside_N,
                   const SheetState &state) {
    for (int c = 0, at = 0; c < 3; ++c)
      for (int i = 0; i < places; ++i, ++at)
        state.velocity_m_per_s[at] += kick_s * mobility_1_kg[i] * (outside_N[at] - state.internal_N[at]);
  }

  // A component of what makes nodes drift and of where they come to, (places) each; `moved_m` is null for a
  // sheet without branches, which need not know how far it went.
  struct NodeDrift {
    const double *mobility_1_kg, *outside_N, *internal_N, *flat_m;
    double *velocity_m_per_s, *position_m, *bent_m, *moved_m;
  };

  // A kick and a step of motion; says how far it went, and how far from flat it led.
  void drift(double kick_s, double step_s, const SheetState &state) {
    const int places = places_.size();
    for (int at = 0; at < size(); at += places)
      drift_all(places, kick_s, step_s,
                {mobility_1_kg_.data(), outside_N_.data() + at, state.internal_N + at, flat_m_.data() + at,
                 state.velocity_m_per_s + at, state.position_m + at, bent_m_.data() + at,
                 branches_.count() ? moved_m_.data() + at : nullptr});
  }

  FLIPFLOW_CLONES
  static void drift_all(int places, double kick_s, double step_s, const NodeDrift of) {
#pragma omp simd
    for (int i = 0; i < places; ++i) {
      const double force_N = of.outside_N[i] - of.internal_N[i];
      const double v = of.velocity_m_per_s[i] + kick_s * of.mobility_1_kg[i] * force_N;
      const double before_m = of.position_m[i], now_m = before_m + step_s * v;
      of.velocity_m_per_s[i] = v;
      of.position_m[i] = now_m;
      of.bent_m[i] = now_m - of.flat_m[i];
      if (of.moved_m) of.moved_m[i] = now_m - before_m;
    }
  }

  // Gives nodes that move alike equal shares of their forces (3, places).
  void join(double *force_N) const {
    for (size_t pair = 0; pair < nodes_.joined.size(); pair += 2)
      for (int c = 0; c < 3; ++c) {
        double &one = force_N[at(nodes_.joined[pair], c)], &other = force_N[at(nodes_.joined[pair + 1], c)];
        one = other = 0.5 * (one + other);
      }
  }

  Works find_force(const SheetState &state) {
    Works works = {StepWork(branches_.count()), StepWork(branches_.count())};
    static const auto find_here = fitting(find_v4, find_v3, find_any);
    find_here(*this, state, works);
    join(state.internal_N);
    return works;
  }

  template <class V>
  FLIPFLOW_INLINE void find_all(const SheetState &state, Works &works) {
    membrane_.step<V>(branches_, state.position_m, state.strain, state.strain_stress, works.stretching);
    const NodeStep step = {bent_m_.data(), moved_m_.data(), state.elastic_N, state.bending_stress_N,
                           state.internal_N};
    bending_.step<V>(branches_, membrane_, step, works.bending);
  }

  FLIPFLOW_V4 static void find_v4(Sheet &s, const SheetState &at, Works &works) { s.find_all<Eight>(at, works); }
  FLIPFLOW_V3 static void find_v3(Sheet &s, const SheetState &at, Works &works) { s.find_all<Four>(at, works); }
  static void find_any(Sheet &s, const SheetState &at, Works &works) { s.find_all<Two>(at, works); }

  // Held nodes have not drifted by their own velocity but go along their path.
  void place_held(const SheetState &state, const HeldPath &path, double fraction) {
    for (int i = 0; i < 3 * held(); ++i) {
      const int at = held_at_[i];
      const double now_m = path.position_m(i, fraction);
      moved_m_.data()[at] = now_m - before_m_[i];
      bent_m_.data()[at] = now_m - flat_m_.data()[at];
      state.position_m[at] = now_m;
      state.velocity_m_per_s[at] = path.velocity_m_per_s(i, fraction);
    }
  }

  double collect(const SheetState &state, double step_s, double *impulse_N_s) const {
    double work_J = 0.0;
    for (int i = 0; i < 3 * held(); ++i) {
      const double mean_N = 0.5 * (before_N_[i] + state.internal_N[held_at_[i]]);
      impulse_N_s[i] += step_s * mean_N;
      work_J += mean_N * moved_m_.data()[held_at_[i]];
    }
    return work_J;
  }

  NodePlaces places_;
  Membrane membrane_;
  Bending bending_;
  Branches branches_;
  SheetNodes nodes_;
  std::vector<int> held_at_;                       // (held, 3), in (3, places)
  std::vector<int> place_;                         // (nodes)
  Numbers mobility_1_kg_;                          // (places)
  Numbers flat_m_, outside_N_, bent_m_, moved_m_;  // (3, places)
  std::vector<double> before_m_, before_N_;        // (held, 3) at the step's start
};

}  // namespace flipflow
