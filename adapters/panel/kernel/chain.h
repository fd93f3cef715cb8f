#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "maxwell.h"
#include "interval.h"

namespace flipflow {

// What a chain is made of: adapters/panel/strip/chain.py.
struct ChainParts {
  // Rows, and how they are held.
  std::vector<double> mass_kg;    // (rows)
  std::vector<double> weight_N;   // (rows, 3)
  std::vector<int> held, free;    // rows
  std::vector<double> across;     // (3) unit vector across the strip
  std::vector<double> share;      // (rows, held): how rows follow the held ones across

  // Axial springs between rows, and bending springs.
  int first;                               // row where the springs begin
  double rest_m;                           // of every spring
  double c10_Pa, c01_Pa, sheared_Pa;       // of its law
  std::vector<double> area_m2;             // (springs)
  std::vector<double> branch_N_per_m;      // (springs): with which each branch answers, over its ratio
  std::vector<double> bending_N_m3;        // (bends)
  std::vector<double> curvature_1_m2;      // (bends, 3): of rows k, k + 1, k + 2 in bend k
  std::vector<int> at_clamp;               // (bends): does the bend count across its `along` only?
  std::vector<double> along;               // (bends, 3) unit vectors of bends at clamps
  std::vector<double> gap_m;               // (rows - 1): lengths of the links between rows
  std::vector<double> moulded_N_m;         // (bends): moments of the stress-free curvatures

  int rows() const { return static_cast<int>(mass_kg.size()); }
  int springs() const { return static_cast<int>(area_m2.size()); }
  int bends() const { return static_cast<int>(bending_N_m3.size()); }
  int strains() const { return springs() + 3 * bends(); }
};

// All that changes while a chain moves; arrays that Python owns.  Position, velocity and internal
// force (rows, 3); `strain`, the springs' lengths, then the curvatures (bends, 3); the branches'
// `stress` (branches, strains) and `energy_J` (branches); `lost_J` (1) since the start.
// `clamp_half_m` (held, 3), the half widths of the held rows, and `received_J` (2) from the load and
// from the clamps belong to the strip, whose points stand to both sides of the rows.
struct ChainState {
  double *position_m, *velocity_m_per_s, *internal_N;
  double *strain, *stress, *energy_J, *lost_J;
  double *clamp_half_m, *received_J;
};

// A chain in motion: velocity Verlet with Maxwell branches.  Across, free rows follow the held ones
// linearly, and what pushes them across goes to the held ones at once
// (docs/theory/panel_strip.md).
class Chain {
 public:
  Chain(ChainParts parts, Branches branches)
      : parts_(std::move(parts)),
        branches_(std::move(branches)),
        before_m_(size()),
        before_N_(size()),
        start_m_per_s_(size()),
        start_m_(size()),
        outside_N_(size()),
        impulse_N_s_(size()),
        acting_(size()),
        moved_across_(held()),
        mobility_1_kg_(size()),
        free_(size()),
        strain_(parts_.strains()),
        change_(parts_.strains()),
        push_(parts_.strains()),
        over_(parts_.strains()),
        stiffness_(parts_.branch_N_per_m),
        direction_(3 * parts_.springs()),
        pull_N_(3 * parts_.springs() + 6),
        moment_(3 * parts_.bends() + 12),
        work_(branches_.count()) {
    for (const double bending_N_m3 : parts_.bending_N_m3)
      stiffness_.insert(stiffness_.end(), 3, bending_N_m3);
    for (auto &of_row : curvature_1_m2_) of_row.assign(moment_.size(), 0.0);
    for (int k = 0; k < parts_.bends(); ++k)
      for (int j = 0; j < 3; ++j)
        std::fill_n(&curvature_1_m2_[j][6 + 3 * k], 3, parts_.curvature_1_m2[3 * k + j]);
    for (const int row : parts_.free)
      for (int i = 3 * row; i < 3 * row + 3; ++i)
        free_[i] = 1.0, mobility_1_kg_[i] = 1.0 / parts_.mass_kg[row];
  }

  int size() const { return 3 * parts_.rows(); }
  int points() const { return parts_.rows(); }
  int held() const { return static_cast<int>(parts_.held.size()); }
  int clamp_points() const { return 2 * held(); }
  int surface_points() const { return 2 * parts_.rows(); }

  // Takes the positions as the shape in which every branch is relaxed.
  void rest(const ChainState &state) {
    branches_.set_relaxed();
    find_force(state);
    std::fill_n(state.energy_J, branches_.count(), 0.0);
    state.lost_J[0] = 0.0;
  }

  // Moves the state in `steps` steps under a constant force (rows, 3).  Adds the impulse (held, 3)
  // that the chain gives to the held rows, and returns its work on them.
  double advance(const ChainState &state, const HeldPath &path, const double *outside_N, int steps,
                 double *impulse_N_s) {
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
      sum_up(state, step_s, outside_N);
      done_J += work_J(acting_.data(), before_m_.data());
    }
    set_end_velocity(state, path);
    for (int i = 0; i < size(); ++i)
      impulse_N_s_[i] -= parts_.mass_kg[i / 3] * (state.velocity_m_per_s[i] - start_m_per_s_[i]);
    add_onto_held(impulse_N_s_.data(), impulse_N_s);
    return done_J - imposed_J(state.velocity_m_per_s) + imposed_J(start_m_per_s_.data());
  }

  // Moves the strip over an interval, as Strip of adapters/panel/strip/panel.py does; points stand row
  // by row, first y = 0, then y = width.  Fills in the surface's motion (points, 3) at the end and the
  // mean force on the clamps (clamp points, 3), adds the work of the load and of the clamps to the
  // state's books, and returns the smallest and the largest stretch of the springs.
  std::pair<double, double> pass(const ChainState &state, const PanelInterval &now,
                                 const PanelSurface &surface, double *reaction_N) {
    const int count = 3 * held();
    const auto middle = [](const double *points, int i) {  // of row i / 3, component i % 3
      return 0.5 * (points[6 * (i / 3) + i % 3] + points[6 * (i / 3) + 3 + i % 3]);
    };
    const auto half = [](const double *points, int i) {
      return 0.5 * (points[6 * (i / 3) + 3 + i % 3] - points[6 * (i / 3) + i % 3]);
    };
    const auto set = [](double *points, int i, double middle, double half) {
      points[6 * (i / 3) + i % 3] = middle - half;
      points[6 * (i / 3) + 3 + i % 3] = middle + half;
    };
    std::vector<double> from_m(count), from_m_per_s(count), to_m(count), to_m_per_s(count);
    std::vector<double> impulse_N_s(count), turning_N(count), half_m_per_s(count);
    for (int i = 0; i < count; ++i) {
      const int at = 3 * parts_.held[i / 3] + i % 3;
      from_m[i] = state.position_m[at];
      from_m_per_s[i] = state.velocity_m_per_s[at];
      to_m[i] = middle(now.clamps_m, i);
      to_m_per_s[i] = middle(now.clamps_m_per_s, i);
      half_m_per_s[i] = half(now.clamps_m_per_s, i);
    }
    std::copy_n(state.position_m, size(), start_m_.begin());
    for (int i = 0; i < size(); ++i) {
      outside_N_[i] = 2.0 * middle(now.load_N, i) + parts_.weight_N[i];
      for (int k = 0; k < held(); ++k)
        turning_N[3 * k + i % 3] += share(i / 3, k) * 2.0 * half(now.load_N, i);
    }
    const HeldPath path = {from_m.data(), from_m_per_s.data(), to_m.data(), to_m_per_s.data(),
                           now.length_s};
    double clamps_J = -advance(state, path, outside_N_.data(), now.steps, impulse_N_s.data());
    double load_J = 0.0;
    for (int i = 0; i < count; ++i) {
      const double end_half_m = half(now.clamps_m, i);
      const double turning_J = turning_N[i] * (end_half_m - state.clamp_half_m[i]);
      clamps_J -= turning_J;
      load_J += turning_J;
      state.clamp_half_m[i] = end_half_m;
      set(reaction_N, i, 0.5 * impulse_N_s[i] / now.length_s, 0.5 * turning_N[i]);
    }
    for (int i = 0; i < size(); ++i) {
      load_J += 2.0 * middle(now.load_N, i) * (state.position_m[i] - start_m_[i]);
      double own_half_m = 0.0, own_half_m_per_s = 0.0;
      for (int k = 0; k < held(); ++k) {
        own_half_m += share(i / 3, k) * state.clamp_half_m[3 * k + i % 3];
        own_half_m_per_s += share(i / 3, k) * half_m_per_s[3 * k + i % 3];
      }
      set(surface.position_m, i, state.position_m[i], own_half_m);
      set(surface.velocity_m_per_s, i, state.velocity_m_per_s[i], own_half_m_per_s);
    }
    state.received_J[0] += load_J;
    state.received_J[1] += clamps_J;
    return stretches(state);
  }

 private:
  double share(int row, int k) const { return parts_.share[row * held() + k]; }

  // The smallest and the largest stretch of the springs; both are NaN if one of them is.
  std::pair<double, double> stretches(const ChainState &state) const {
    double lowest = state.strain[0], highest = state.strain[0];
    for (int i = 0; i < parts_.springs(); ++i) {
      if (state.strain[i] != state.strain[i]) return {state.strain[i], state.strain[i]};
      lowest = std::min(lowest, state.strain[i]);
      highest = std::max(highest, state.strain[i]);
    }
    return {lowest / parts_.rest_m, highest / parts_.rest_m};
  }

  // Vectors are three numbers in a row.
  FLIPFLOW_INLINE static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  FLIPFLOW_INLINE static void add(double factor, const double *vector, double *to) {
    for (int c = 0; c < 3; ++c) to[c] += factor * vector[c];
  }

  // Adds the part of a vector that is normal to the unit vector `n`.
  static void add_normal_part(double factor, const double *vector, const double *n, double *to) {
    add(factor, vector, to);
    add(-factor * dot(vector, n), n, to);
  }

  // Sets the force of springs, bending springs and the branches on both, and carries `strain` and
  // the branches' stresses to the present positions.
  FLIPFLOW_CLONES
  const StepWork &find_force(const ChainState &state) {
    find_strain(state.position_m);
    find_overstress(state.strain, state.stress);
    const int springs = parts_.springs();
    const double rest_m = parts_.rest_m, c10_Pa = parts_.c10_Pa, c01_Pa = parts_.c01_Pa;
    const double sheared_Pa = parts_.sheared_Pa, *length_m = strain_.data(), *area_m2 = parts_.area_m2.data();
    double *tension_N = over_.data();  // of springs; the moments' own numbers stand behind
#pragma omp simd
    for (int i = 0; i < springs; ++i) {
      const double stretch = length_m[i] / rest_m, per_stretch = rest_m / length_m[i];
      const double square = per_stretch * per_stretch;
      const double stress_Pa = 2.0 * ((stretch - square) * (c10_Pa + c01_Pa * per_stretch) +
                                      (stretch - square * per_stretch) * sheared_Pa);
      tension_N[i] += area_m2[i] * stress_Pa;
    }
    for (int i = 0; i < springs; ++i)
      for (int c = 0; c < 3; ++c) pull_N_[3 + 3 * i + c] = tension_N[i] * direction_[3 * i + c];
    double *internal_N = state.internal_N, *moment = moment_.data();
    const double *curved = &strain_[springs], *stiff = &stiffness_[springs], *over = &over_[springs];
#pragma omp simd
    for (int i = 0; i < 3 * parts_.bends(); ++i) moment[6 + i] = stiff[i] * curved[i] + over[i];
    const double *by[3] = {curvature_1_m2_[0].data(), curvature_1_m2_[1].data(), curvature_1_m2_[2].data()};
#pragma omp simd
    for (int i = 0; i < size(); ++i)
      internal_N[i] =
          -(by[0][i + 6] * moment[i + 6] + by[1][i + 3] * moment[i + 3] + by[2][i] * moment[i]);
    const double *pull_N = pull_N_.data();
    double *sprung_N = internal_N + 3 * parts_.first;
#pragma omp simd
    for (int i = 0; i < 3 * springs + 3; ++i) sprung_N[i] += pull_N[i + 3] - pull_N[i];
    for (int k = 0; k < parts_.bends(); ++k)
      if (parts_.moulded_N_m[k] != 0.0) add_moulded(k, state);
    return work_;
  }

  // Adds the force of a stress-free curvature, whose energy is its moment times across . (d x d'), with
  // the slopes d and d' of the links before and after the middle row.
  FLIPFLOW_INLINE void add_moulded(int k, const ChainState &state) const {
    const double *across = parts_.across.data(), *row_m = state.position_m + 3 * k;
    double *force_N = state.internal_N + 3 * k;
    const double gap_m[2] = {parts_.gap_m[k], parts_.gap_m[k + 1]};
    double slope[2][3];
    for (int i = 0; i < 2; ++i)
      for (int c = 0; c < 3; ++c) slope[i][c] = (row_m[3 * i + 3 + c] - row_m[3 * i + c]) / gap_m[i];
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      const double by_first = slope[1][d] * across[e] - slope[1][e] * across[d];
      const double by_second = across[d] * slope[0][e] - across[e] * slope[0][d];
      const double first_N = parts_.moulded_N_m[k] * by_first / gap_m[0];
      const double second_N = parts_.moulded_N_m[k] * by_second / gap_m[1];
      force_N[c] += first_N;
      force_N[3 + c] += second_N - first_N;
      force_N[6 + c] -= second_N;
    }
  }

  FLIPFLOW_INLINE void find_strain(const double *position_m) {
    const double *first_m = position_m + 3 * parts_.first;
    double *direction = direction_.data(), *curvature = &strain_[parts_.springs()];
#pragma omp simd
    for (int i = 0; i < 3 * parts_.springs(); ++i) direction[i] = first_m[i + 3] - first_m[i];
    double *length_m = strain_.data();
#pragma omp simd
    for (int i = 0; i < parts_.springs(); ++i)
      length_m[i] = std::sqrt(dot(direction + 3 * i, direction + 3 * i));
    for (int i = 0; i < parts_.springs(); ++i)
      for (int c = 0; c < 3; ++c) direction[3 * i + c] /= length_m[i];
    const double *by[3] = {&curvature_1_m2_[0][6], &curvature_1_m2_[1][6], &curvature_1_m2_[2][6]};
#pragma omp simd
    for (int i = 0; i < 3 * parts_.bends(); ++i)
      curvature[i] =
          by[0][i] * position_m[i] + by[1][i] * position_m[i + 3] + by[2][i] * position_m[i + 6];
    for (int k = 0; k < parts_.bends(); ++k) {
      const double *along = &parts_.along[3 * k];
      if (parts_.at_clamp[k]) add(-dot(curvature + 3 * k, along), along, curvature + 3 * k);
    }
  }

  FLIPFLOW_INLINE void find_overstress(double *strain, double *stress) {
    const int strains = parts_.strains();
    double *change = change_.data(), *push = push_.data(), *over = over_.data(), square_J = 0.0;
    const double *now = strain_.data(), *stiffness = stiffness_.data();
#pragma omp simd reduction(+ : square_J)
    for (int i = 0; i < strains; ++i) {
      change[i] = now[i] - strain[i];
      strain[i] = now[i];
      push[i] = stiffness[i] * change[i];
      square_J += change[i] * push[i];
      over[i] = 0.0;
    }
    work_.square_J[0] = square_J;
    for (int b = 0; b < branches_.count(); ++b) {
      const double decay = branches_.decay()[b], gain = branches_.gain()[b], ratio = branches_.ratio()[b];
      double *own = stress + b * strains, cross_J = 0.0;
#pragma omp simd reduction(+ : cross_J)
      for (int i = 0; i < strains; ++i) {
        cross_J += own[i] * change[i];
        own[i] = decay * own[i] + gain * push[i];
        over[i] += ratio * own[i];
      }
      work_.cross_J[b * kLanes] = cross_J;
    }
  }

  // Sums up the impulse of what acts in a step, (rows, 3) as `acting_`; `before_m_` becomes what they moved by.
  FLIPFLOW_CLONES
  void sum_up(const ChainState &state, double step_s, const double *outside_N) {
    const double *internal_N = state.internal_N, *position_m = state.position_m, *before_N = before_N_.data();
    double *acting_N = acting_.data(), *impulse_N_s = impulse_N_s_.data(), *before_m = before_m_.data();
#pragma omp simd
    for (int i = 0; i < size(); ++i) {
      acting_N[i] = 0.5 * (before_N[i] + internal_N[i]) + outside_N[i];
      impulse_N_s[i] += step_s * acting_N[i];
      before_m[i] = position_m[i] - before_m[i];
    }
  }

  // Half a step of force on the free rows; its part across is dropped at the interval's end.
  FLIPFLOW_CLONES
  void kick(const ChainState &state, double half_step_s, const double *outside_N) const {
    const double *mobility_1_kg = mobility_1_kg_.data(), *internal_N = state.internal_N;
    double *velocity_m_per_s = state.velocity_m_per_s;
#pragma omp simd
    for (int i = 0; i < size(); ++i)
      velocity_m_per_s[i] += half_step_s * mobility_1_kg[i] * (outside_N[i] + internal_N[i]);
  }

  FLIPFLOW_CLONES
  void move(const ChainState &state, const HeldPath &path, double fraction, double step_s) {
    const double *across = parts_.across.data(), *velocity_m_per_s = state.velocity_m_per_s;
    double *position_m = state.position_m;
    for (int k = 0; k < held(); ++k) {
      double *place_m = position_m + 3 * parts_.held[k];
      moved_across_[k] = -dot(place_m, across);
      for (int c = 0; c < 3; ++c) place_m[c] = path.position_m(3 * k + c, fraction);
      moved_across_[k] += dot(place_m, across);
    }
    for (const int row : parts_.free)
      add(spread(row) - step_s * dot(velocity_m_per_s + 3 * row, across), across, position_m + 3 * row);
    const double *free = free_.data();
#pragma omp simd
    for (int i = 0; i < size(); ++i) position_m[i] += free[i] * step_s * velocity_m_per_s[i];
  }

  // The held rows' velocity is the path's, and so is that across of all rows.
  void set_end_velocity(const ChainState &state, const HeldPath &path) {
    const double *across = parts_.across.data();
    for (int k = 0; k < held(); ++k) {
      moved_across_[k] = dot(path.end_m_per_s + 3 * k, across);
      std::copy_n(path.end_m_per_s + 3 * k, 3, state.velocity_m_per_s + 3 * parts_.held[k]);
    }
    for (const int row : parts_.free) {
      double *velocity_m_per_s = state.velocity_m_per_s + 3 * row;
      add(spread(row) - dot(velocity_m_per_s, across), across, velocity_m_per_s);
    }
  }

  // How a free row follows the held ones across.
  FLIPFLOW_INLINE double spread(int row) const {
    double moved = 0.0;
    for (int k = 0; k < held(); ++k) moved += share(row, k) * moved_across_[k];
    return moved;
  }

  // The transpose: all of the held rows' own, and of every row what is across.
  void add_onto_held(const double *rows, double *held_rows) const {
    const double *across = parts_.across.data();
    for (int k = 0; k < held(); ++k) {
      add_normal_part(1.0, rows + 3 * parts_.held[k], across, held_rows + 3 * k);
      double handed = 0.0;
      for (int row = 0; row < parts_.rows(); ++row)
        handed += share(row, k) * dot(rows + 3 * row, across);
      add(handed, across, held_rows + 3 * k);
    }
  }

  // Work on imposed motion: of held rows in the plane, of all rows across.
  double work_J(const double *force_N, const double *moved_m) const {
    const double *across = parts_.across.data();
    double work = 0.0;
    for (int row = 0; row < parts_.rows(); ++row)
      work += dot(force_N + 3 * row, across) * dot(moved_m + 3 * row, across);
    for (const int row : parts_.held)
      work += dot(force_N + 3 * row, moved_m + 3 * row) -
              dot(force_N + 3 * row, across) * dot(moved_m + 3 * row, across);
    return work;
  }

  // Kinetic energy of imposed motion.
  double imposed_J(const double *velocity_m_per_s) {
    for (int i = 0; i < size(); ++i)
      acting_[i] = 0.5 * parts_.mass_kg[i / 3] * velocity_m_per_s[i];
    return work_J(acting_.data(), velocity_m_per_s);
  }

  ChainParts parts_;
  Branches branches_;
  std::vector<double> before_m_, before_N_, start_m_per_s_, start_m_, outside_N_;   // (rows, 3)
  std::vector<double> impulse_N_s_, acting_;                                        // (rows, 3)
  std::vector<double> moved_across_;                                                // (held)
  std::vector<double> mobility_1_kg_, free_;                                        // (rows, 3): 0 if held
  std::vector<double> strain_, change_, push_, over_, stiffness_;                   // (strains)
  std::vector<double> direction_;                                                   // (springs, 3)
  // With zeros before the first and after the last, so that each row has as many neighbours.
  std::vector<double> pull_N_;                                                      // (1 + springs + 1, 3)
  std::vector<double> moment_, curvature_1_m2_[3];                                  // (2 + bends + 2, 3)
  StepWork work_;
};

}  // namespace flipflow
