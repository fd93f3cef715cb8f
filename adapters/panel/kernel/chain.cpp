#include "chain.h"

#include <algorithm>

#include "vector3.h"

namespace flipflow {

Chain::Chain(ChainForce force, ChainRows rows, Branches branches)
    : force_(std::move(force)),
      rows_(std::move(rows)),
      branches_(std::move(branches)),
      before_m_(size()),
      before_N_(size()),
      start_m_per_s_(size()),
      impulse_N_s_(size()),
      acting_(size()),
      moved_across_(held()) {}

void Chain::rest(const ChainState &state) {
  branches_.set_relaxed();
  find_force(state);
  std::fill_n(state.energy_J, branches(), 0.0);
  state.lost_J[0] = 0.0;
}

double Chain::advance(const ChainState &state, const HeldPath &path, const double *outside_N,
                      int steps, double *impulse_N_s) {
  const double step_s = path.length_s / steps;
  branches_.set_step(step_s);
  std::copy_n(state.velocity_m_per_s, size(), start_m_per_s_.begin());
  std::fill(impulse_N_s_.begin(), impulse_N_s_.end(), 0.0);
  double done_J = 0.0;
  for (int step = 1; step <= steps; ++step) {
    std::copy_n(state.position_m, size(), before_m_.begin());
    std::copy_n(state.internal_N, size(), before_N_.begin());
    kick(state, 0.5 * step_s, outside_N);
    move(state, path, static_cast<double>(step) / steps, step_s);
    state.lost_J[0] += branches_.book(find_force(state), state.energy_J);
    kick(state, 0.5 * step_s, outside_N);
    for (int i = 0; i < size(); ++i) {
      acting_[i] = 0.5 * (before_N_[i] + state.internal_N[i]) + outside_N[i];
      impulse_N_s_[i] += step_s * acting_[i];
      before_m_[i] = state.position_m[i] - before_m_[i];  // now what it moved by
    }
    done_J += work_J(acting_.data(), before_m_.data());
  }
  set_end_velocity(state, path);
  for (int i = 0; i < size(); ++i)
    impulse_N_s_[i] -= rows_.mass_kg[i / 3] * (state.velocity_m_per_s[i] - start_m_per_s_[i]);
  onto_held(impulse_N_s_.data(), impulse_N_s);
  return done_J - imposed_J(state.velocity_m_per_s) + imposed_J(start_m_per_s_.data());
}

StepWork Chain::find_force(const ChainState &state) {
  std::fill_n(state.internal_N, size(), 0.0);
  return force_.step(branches_, state.position_m, state.strain, state.stress, state.internal_N);
}

// Half a step of force on the free rows; its part across is dropped at the interval's end.
void Chain::kick(const ChainState &state, double half_step_s, const double *outside_N) const {
  for (const int row : rows_.free)
    for (int i = 3 * row; i < 3 * row + 3; ++i)
      state.velocity_m_per_s[i] +=
          half_step_s / rows_.mass_kg[row] * (outside_N[i] + state.internal_N[i]);
}

void Chain::move(const ChainState &state, const HeldPath &path, double fraction, double step_s) {
  const double *across = rows_.across.data();
  for (int k = 0; k < held(); ++k) {
    double *place_m = state.position_m + 3 * rows_.held[k];
    moved_across_[k] = -dot(place_m, across);
    for (int c = 0; c < 3; ++c) place_m[c] = path.position_m(3 * k + c, fraction);
    moved_across_[k] += dot(place_m, across);
  }
  for (const int row : rows_.free) {
    add(spread(row), across, state.position_m + 3 * row);
    add_normal_part(step_s, state.velocity_m_per_s + 3 * row, across, state.position_m + 3 * row);
  }
}

// The held rows' velocity is the path's, and so is that across of all rows.
void Chain::set_end_velocity(const ChainState &state, const HeldPath &path) {
  const double *across = rows_.across.data();
  for (int k = 0; k < held(); ++k) {
    moved_across_[k] = dot(path.end_m_per_s + 3 * k, across);
    std::copy_n(path.end_m_per_s + 3 * k, 3, state.velocity_m_per_s + 3 * rows_.held[k]);
  }
  for (const int row : rows_.free) {
    double *velocity_m_per_s = state.velocity_m_per_s + 3 * row;
    add(spread(row) - dot(velocity_m_per_s, across), across, velocity_m_per_s);
  }
}

// How a free row follows the held ones across.
double Chain::spread(int row) const {
  double moved = 0.0;
  for (int k = 0; k < held(); ++k) moved += rows_.share[row * held() + k] * moved_across_[k];
  return moved;
}

// The transpose: all of the held rows' own, and of every row what is across.
void Chain::onto_held(const double *rows, double *held_rows) const {
  const double *across = rows_.across.data();
  for (int k = 0; k < held(); ++k) {
    add_normal_part(1.0, rows + 3 * rows_.held[k], across, held_rows + 3 * k);
    double handed = 0.0;
    for (int row = 0; row < rows_.count(); ++row)
      handed += rows_.share[row * held() + k] * dot(rows + 3 * row, across);
    add(handed, across, held_rows + 3 * k);
  }
}

// Work on imposed motion: of held rows in the plane, of all rows across.
double Chain::work_J(const double *force_N, const double *moved_m) const {
  const double *across = rows_.across.data();
  double work = 0.0;
  for (int row = 0; row < rows_.count(); ++row)
    work += dot(force_N + 3 * row, across) * dot(moved_m + 3 * row, across);
  for (const int row : rows_.held)
    work += dot(force_N + 3 * row, moved_m + 3 * row) -
            dot(force_N + 3 * row, across) * dot(moved_m + 3 * row, across);
  return work;
}

// Kinetic energy of imposed motion.
double Chain::imposed_J(const double *velocity_m_per_s) {
  for (int i = 0; i < size(); ++i) acting_[i] = 0.5 * rows_.mass_kg[i / 3] * velocity_m_per_s[i];
  return work_J(acting_.data(), velocity_m_per_s);
}

}  // namespace flipflow
