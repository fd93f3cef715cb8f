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
        strain_(parts_.strains()),
        over_(parts_.strains()),
        stiffness_(parts_.branch_N_per_m),
        direction_(3 * parts_.springs()) {
    for (const double bending_N_m3 : parts_.bending_N_m3)
      stiffness_.insert(stiffness_.end(), 3, bending_N_m3);
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
      for (int i = 0; i < size(); ++i) {
        acting_[i] = 0.5 * (before_N_[i] + state.internal_N[i]) + outside_N[i];
        impulse_N_s_[i] += step_s * acting_[i];
        before_m_[i] = state.position_m[i] - before_m_[i];  // now what it moved by
      }
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
  static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  static void add(double factor, const double *vector, double *to) {
    for (int c = 0; c < 3; ++c) to[c] += factor * vector[c];
  }

  // Adds the part of a vector that is normal to the unit vector `n`.
  static void add_normal_part(double factor, const double *vector, const double *n, double *to) {
    add(factor, vector, to);
    add(-factor * dot(vector, n), n, to);
  }

  // Sets the force of springs, bending springs and the branches on both, and carries `strain` and
  // the branches' stresses to the present positions.
  StepWork find_force(const ChainState &state) {
    std::fill_n(state.internal_N, size(), 0.0);
    find_strain(state.position_m);
    const StepWork work = find_overstress(state.strain, state.stress);
    for (int i = 0; i < parts_.springs(); ++i) {
      const double stretch = strain_[i] / parts_.rest_m, per_stretch = 1.0 / stretch;
      const double square = per_stretch * per_stretch;
      const double stress_Pa =
          2.0 * ((stretch - square) * (parts_.c10_Pa + parts_.c01_Pa * per_stretch) +
                 (stretch - square * per_stretch) * parts_.sheared_Pa);
      const double tension_N = parts_.area_m2[i] * stress_Pa + over_[i];
      double *first_N = state.internal_N + 3 * (parts_.first + i);
      add(tension_N, &direction_[3 * i], first_N);
      add(-tension_N, &direction_[3 * i], first_N + 3);
    }
    for (int k = 0; k < parts_.bends(); ++k) {
      const int at = parts_.springs() + 3 * k;
      double moment[3];
      for (int c = 0; c < 3; ++c) moment[c] = stiffness_[at + c] * strain_[at + c] + over_[at + c];
      for (int j = 0; j < 3; ++j)
        add(-parts_.curvature_1_m2[3 * k + j], moment, state.internal_N + 3 * (k + j));
    }
    for (int k = 0; k < parts_.bends(); ++k)
      if (parts_.moulded_N_m[k] != 0.0) add_moulded(k, state);
    return work;
  }

  // Adds the force of a stress-free curvature, whose energy is its moment times across . (d x d'), with
  // the slopes d and d' of the links before and after the middle row.
  void add_moulded(int k, const ChainState &state) const {
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

  void find_strain(const double *position_m) {
    for (int i = 0; i < parts_.springs(); ++i) {
      const double *first_m = position_m + 3 * (parts_.first + i);
      double *direction = &direction_[3 * i];
      for (int c = 0; c < 3; ++c) direction[c] = first_m[3 + c] - first_m[c];
      strain_[i] = std::sqrt(dot(direction, direction));
      for (int c = 0; c < 3; ++c) direction[c] /= strain_[i];
    }
    for (int k = 0; k < parts_.bends(); ++k) {
      const double *along = &parts_.along[3 * k];
      double *curvature = &strain_[parts_.springs() + 3 * k];
      std::fill_n(curvature, 3, 0.0);
      for (int j = 0; j < 3; ++j)
        add(parts_.curvature_1_m2[3 * k + j], position_m + 3 * (k + j), curvature);
      if (parts_.at_clamp[k]) add(-dot(curvature, along), along, curvature);
    }
  }

  StepWork find_overstress(double *strain, double *stress) {
    StepWork work(branches_.count());
    const int strains = parts_.strains();
    for (int i = 0; i < strains; ++i) {
      const double change = strain_[i] - strain[i], push = stiffness_[i] * change;
      strain[i] = strain_[i];
      work.square_J[0] += change * push;
      over_[i] = 0.0;
      for (int b = 0; b < branches_.count(); ++b) {
        double &own = stress[b * strains + i];
        work.cross_J[b * kLanes] += own * change;
        own = branches_.decay()[b] * own + branches_.gain()[b] * push;
        over_[i] += branches_.ratio()[b] * own;
      }
    }
    return work;
  }

  // Half a step of force on the free rows; its part across is dropped at the interval's end.
  void kick(const ChainState &state, double half_step_s, const double *outside_N) const {
    for (const int row : parts_.free)
      for (int i = 3 * row; i < 3 * row + 3; ++i)
        state.velocity_m_per_s[i] +=
            half_step_s / parts_.mass_kg[row] * (outside_N[i] + state.internal_N[i]);
  }

  void move(const ChainState &state, const HeldPath &path, double fraction, double step_s) {
    const double *across = parts_.across.data();
    for (int k = 0; k < held(); ++k) {
      double *place_m = state.position_m + 3 * parts_.held[k];
      moved_across_[k] = -dot(place_m, across);
      for (int c = 0; c < 3; ++c) place_m[c] = path.position_m(3 * k + c, fraction);
      moved_across_[k] += dot(place_m, across);
    }
    for (const int row : parts_.free) {
      add(spread(row), across, state.position_m + 3 * row);
      add_normal_part(step_s, state.velocity_m_per_s + 3 * row, across, state.position_m + 3 * row);
    }
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
  double spread(int row) const {
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
  std::vector<double> strain_, over_, stiffness_;                                   // (strains)
  std::vector<double> direction_;                                                   // (springs, 3)
};

}  // namespace flipflow
