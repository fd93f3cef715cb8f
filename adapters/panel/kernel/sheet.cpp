#include "sheet.h"

#include <algorithm>

#include "lanes.h"

namespace flipflow {

namespace {

// Half a step of force on the free nodes.
FLIPFLOW_CLONES
void kick(int size, double half_step_s, const double *mobility_1_kg, const double *outside_N,
          const double *internal_N, double *velocity_m_per_s) {
  for (int i = 0; i < size; ++i)
    velocity_m_per_s[i] += half_step_s * mobility_1_kg[i] * (outside_N[i] - internal_N[i]);
}

FLIPFLOW_CLONES
void drift(int size, double step_s, const double *velocity_m_per_s, double *position_m) {
  for (int i = 0; i < size; ++i) position_m[i] += step_s * velocity_m_per_s[i];
}

}  // namespace

Sheet::Sheet(Membrane membrane, Bending bending, Branches branches, const double *mobility_1_kg,
             int nodes, std::vector<int> held)
    : membrane_(std::move(membrane)),
      bending_(std::move(bending)),
      branches_(std::move(branches)),
      mobility_(3 * nodes),
      held_(std::move(held)),
      before_m_(3 * nodes),
      before_N_(3 * nodes) {
  for (int i = 0; i < 3 * nodes; ++i) mobility_[i] = mobility_1_kg[i / 3];
}

void Sheet::rest(const SheetState &state) {
  branches_.set_relaxed();
  std::copy_n(state.position_m, size(), before_m_.begin());
  find_force(state);
  std::fill_n(state.energy_J, 2 * branches(), 0.0);
  state.lost_J[0] = 0.0;
}

double Sheet::advance(const SheetState &state, const HeldPath &path, const double *outside_N,
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
    state.lost_J[0] += branches_.book(works.bending, state.energy_J + branches());
    kick(size(), 0.5 * step_s, mobility_.data(), outside_N, state.internal_N, state.velocity_m_per_s);
    work_J += collect(state, step_s, impulse_N_s);
  }
  return work_J;
}

Sheet::Works Sheet::find_force(const SheetState &state) {
  std::fill_n(state.internal_N, size(), 0.0);
  return {membrane_.step(branches_, state.position_m, state.strain, state.strain_stress,
                         state.internal_N),
          bending_.step(branches_, before_m_.data(), state.position_m, state.elastic_N,
                        state.bending_stress_N, state.internal_N)};
}

void Sheet::place_held(const SheetState &state, const HeldPath &path, double fraction) const {
  for (int k = 0; k < held(); ++k)
    for (int c = 0; c < 3; ++c) {
      const int node = 3 * held_[k] + c;
      state.position_m[node] = path.position_m(3 * k + c, fraction);
      state.velocity_m_per_s[node] = path.velocity_m_per_s(3 * k + c, fraction);
    }
}

double Sheet::collect(const SheetState &state, double step_s, double *impulse_N_s) const {
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

}  // namespace flipflow
