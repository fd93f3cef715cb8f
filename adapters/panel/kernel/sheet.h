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

namespace flipflow {

// All that changes while a sheet moves; arrays that Python owns.  (nodes, 3) each, and the
// parts' strains, elastic forces and stresses as in membrane.h and bending.h; `energy_J` (2,
// branches) of the membrane's and of bending's branches, `lost_J` (1) since the start, `received_J`
// (2) from the load and from the clamps.
struct SheetState {
  double *position_m, *velocity_m_per_s, *internal_N;
  double *strain, *strain_stress, *elastic_N, *bending_stress_N;
  double *energy_J, *lost_J, *received_J;
};

// The largest size of a number, or NaN if one of them is NaN.
inline double largest_size(const double *numbers, int size) {
  double largest = 0.0;
  for (int i = 0; i < size; ++i) {
    const double number = std::abs(numbers[i]);
    if (!(number <= largest)) largest = number;
    if (largest != largest) break;
  }
  return largest;
}

// A thin sheet in velocity Verlet: Explicit of adapters/panel/finite_element/integrators.py on the
// structure of sheet_forms.py.
class Sheet {
 public:
  // `mobility_1_kg` (nodes), zero for the nodes `held`; `mass_kg` (nodes), `weight_N` (nodes, 3).
  Sheet(Membrane membrane, Bending bending, Branches branches,
        const std::vector<double> &mobility_1_kg, std::vector<double> mass_kg,
        std::vector<double> weight_N, std::vector<int> held)
      : membrane_(std::move(membrane)),
        bending_(std::move(bending)),
        branches_(std::move(branches)),
        mobility_(3 * mobility_1_kg.size()),
        mass_kg_(std::move(mass_kg)),
        weight_N_(std::move(weight_N)),
        held_(std::move(held)),
        before_m_(mobility_.size()),
        before_N_(mobility_.size()) {
    for (int i = 0; i < size(); ++i) mobility_[i] = mobility_1_kg[i / 3];
  }

  double membrane_J(const double *position_m) const { return membrane_.energy_J(position_m); }
  int size() const { return static_cast<int>(mobility_.size()); }  // 3 * nodes
  int held() const { return static_cast<int>(held_.size()); }
  int clamp_points() const { return held(); }
  int surface_points() const { return size() / 3; }

  // Takes the positions as the shape in which every branch is relaxed.
  void rest(const SheetState &state) {
    branches_.set_relaxed();
    std::copy_n(state.position_m, size(), before_m_.begin());
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
    double work_J = 0.0;
    for (int step = 1; step <= steps; ++step) {
      std::copy_n(state.position_m, size(), before_m_.begin());
      std::copy_n(state.internal_N, size(), before_N_.begin());
      kick(size(), 0.5 * step_s, mobility_.data(), outside_N, state.internal_N, state.velocity_m_per_s);
      drift(size(), step_s, state.velocity_m_per_s, state.position_m);
      place_held(state, path, static_cast<double>(step) / steps);
      const Works works = find_force(state);
      state.lost_J[0] += branches_.book(works.stretching, state.energy_J);
      state.lost_J[0] += branches_.book(works.bending, state.energy_J + branches_.count());
      kick(size(), 0.5 * step_s, mobility_.data(), outside_N, state.internal_N, state.velocity_m_per_s);
      work_J += collect(state, step_s, impulse_N_s);
    }
    return work_J;
  }

  // Moves the state over an interval, as ElasticPanel of adapters/panel/finite_element/elastic_panel.py
  // does: its clamps go on from the held nodes, which they have moved.  Fills in the surface's motion
  // (nodes, 3) at the end and the mean force on the clamps (held, 3), adds the work of the load and of
  // the clamps to the state's books, and returns the largest speed of a node.
  double pass(const SheetState &state, const PanelInterval &now, const PanelSurface &surface,
              double *reaction_N) {
    std::vector<double> start_m(3 * held()), start_m_per_s(3 * held()), impulse_N_s(3 * held());
    std::vector<double> outside_N(size()), start_surface_m(state.position_m, state.position_m + size());
    for (int i = 0; i < size(); ++i) outside_N[i] = weight_N_[i] + now.load_N[i];
    for (int i = 0; i < 3 * held(); ++i) {
      start_m[i] = state.position_m[node(i)];
      start_m_per_s[i] = state.velocity_m_per_s[node(i)];
    }
    const HeldPath path = {start_m.data(), start_m_per_s.data(), now.clamps_m, now.clamps_m_per_s,
                           now.length_s};
    double clamps_J = advance(state, path, outside_N.data(), now.steps, impulse_N_s.data()), load_J = 0.0;
    for (int i = 0; i < 3 * held(); ++i) {
      const double before = start_m_per_s[i], after = state.velocity_m_per_s[node(i)];
      const double gained_N_s = mass_kg_[held_[i / 3]] * (after - before), on_clamp_N = outside_N[node(i)];
      clamps_J += 0.5 * gained_N_s * (after + before);
      clamps_J -= on_clamp_N * (state.position_m[node(i)] - start_m[i]);
      reaction_N[i] = on_clamp_N - (gained_N_s + impulse_N_s[i]) / now.length_s;
    }
    for (int i = 0; i < size(); ++i) load_J += now.load_N[i] * (state.position_m[i] - start_surface_m[i]);
    state.received_J[0] += load_J;
    state.received_J[1] += clamps_J;
    std::copy_n(state.position_m, size(), surface.position_m);
    std::copy_n(state.velocity_m_per_s, size(), surface.velocity_m_per_s);
    return largest_size(state.velocity_m_per_s, size());
  }

 private:
  // The place among the nodes' numbers of number `i` of the held ones'.
  int node(int i) const { return 3 * held_[i / 3] + i % 3; }

  struct Works {
    StepWork stretching, bending;
  };

  // Half a step of force on the free nodes.
  FLIPFLOW_CLONES
  static void kick(int size, double half_step_s, const double *mobility_1_kg, const double *outside_N,
                   const double *internal_N, double *velocity_m_per_s) {
    for (int i = 0; i < size; ++i)
      velocity_m_per_s[i] += half_step_s * mobility_1_kg[i] * (outside_N[i] - internal_N[i]);
  }

  FLIPFLOW_CLONES
  static void drift(int size, double step_s, const double *velocity_m_per_s, double *position_m) {
    for (int i = 0; i < size; ++i) position_m[i] += step_s * velocity_m_per_s[i];
  }

  Works find_force(const SheetState &state) {
    std::fill_n(state.internal_N, size(), 0.0);
    return {membrane_.step(branches_, state.position_m, state.strain, state.strain_stress,
                           state.internal_N),
            bending_.step(branches_, before_m_.data(), state.position_m, state.elastic_N,
                          state.bending_stress_N, state.internal_N)};
  }

  void place_held(const SheetState &state, const HeldPath &path, double fraction) const {
    for (int k = 0; k < held(); ++k)
      for (int c = 0; c < 3; ++c) {
        const int node = 3 * held_[k] + c;
        state.position_m[node] = path.position_m(3 * k + c, fraction);
        state.velocity_m_per_s[node] = path.velocity_m_per_s(3 * k + c, fraction);
      }
  }

  double collect(const SheetState &state, double step_s, double *impulse_N_s) const {
    double work_J = 0.0;
    for (int k = 0; k < held(); ++k)
      for (int c = 0; c < 3; ++c) {
        const int node = 3 * held_[k] + c;
        const double mean_N = 0.5 * (before_N_[node] + state.internal_N[node]);
        impulse_N_s[3 * k + c] += step_s * mean_N;
        work_J += mean_N * (state.position_m[node] - before_m_[node]);
      }
    return work_J;
  }

  Membrane membrane_;
  Bending bending_;
  Branches branches_;
  std::vector<double> mobility_;  // (nodes, 3)
  std::vector<double> mass_kg_, weight_N_;
  std::vector<int> held_;
  std::vector<double> before_m_, before_N_;  // (nodes, 3) at the step's start
};

}  // namespace flipflow
