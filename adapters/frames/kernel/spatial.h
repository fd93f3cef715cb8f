// Rigid bodies in space on bushings, around the steps of a multibody solver: poses, forces, books.
//
// The equations are those of docs/theory/frames.md; tests/frames/spatial_reference.py has them in
// Python, as they are read.  All quantities are in SI units and in the world's axes.  The ground has
// the body number -1, and the last row of the poses.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "../../vec3.h"

namespace flipflow {

// Row `n` of an array of vectors.
inline Vec3 row(const double *rows, std::ptrdiff_t n) { return from(rows + 3 * n); }
inline void put(double *rows, std::ptrdiff_t n, Vec3 v) { put(rows + 3 * n, v); }
inline void add(double *rows, std::ptrdiff_t n, Vec3 v) { add_to(rows + 3 * n, v); }

// Matrix `n` (row by row) of an array times a vector, and its transpose times a vector.
inline Vec3 times(const double *matrices, std::ptrdiff_t n, Vec3 v) {
  const double *m = matrices + 9 * n;
  return {dot(row(m, 0), v), dot(row(m, 1), v), dot(row(m, 2), v)};
}
inline Vec3 transposed_times(const double *matrices, std::ptrdiff_t n, Vec3 v) {
  const double *m = matrices + 9 * n;
  return v.x * row(m, 0) + v.y * row(m, 1) + v.z * row(m, 2);
}

inline Vec3 scaled(const double *rows, std::ptrdiff_t n, Vec3 v) {
  const Vec3 by = row(rows, n);
  return {by.x * v.x, by.y * v.y, by.z * v.z};
}

// Points fixed to bodies, by arms (n, 3) from the centres of mass in body axes.
struct AttachedPoints {
  std::vector<int> body;
  std::vector<double> arm_m;

  std::size_t size() const { return body.size(); }
};

struct SpatialParts {
  // bodies: places of the centres as drawn, weight, inertia (3, 3) in body axes
  std::vector<double> drawn_m, mass_kg, inertia_kg_m2, gravity_m_per_s2;
  std::vector<int> is_free, is_driven;
  // bushings: their two ends, spring axes as rows (3, 3), and values along these axes
  AttachedPoints first, second;
  std::vector<double> axes, stiffness_N_per_m, damping_N_s_per_m, sag_m;
  // exciters of given speed: unit vectors to the unbalance at phase 0 and a quarter turn later
  AttachedPoints excited;
  std::vector<double> mass_moment_kg_m, start, across, speed_rad_per_s, run_up_s, start_s, phase_rad;
  std::vector<double> stop_s, run_down_s;
  // the points that the frames carry
  AttachedPoints carried;

  std::size_t bodies() const { return mass_kg.size(); }
  std::size_t bushings() const { return first.size(); }
  std::size_t exciters() const { return excited.size(); }
};

// The poses and forces at the last step's end, in arrays that Python owns.
struct SpatialState {
  double *center_m, *rotation, *velocity_m_per_s, *spin_rad_per_s, *spin_per_rate;
  // bushings: stretches along the spring axes, the force of other elements along them, and the whole
  // force on the first body at `from_m`
  double *stretch_m, *stretch_m_per_s, *element_N, *pull_N, *from_m, *to_m;
  // bodies: the couple that stretched bushings add to their first body, and that of one step before
  double *couple_N_m, *couple_before_N_m;
  double *exciter_N, *exciter_m;
  double *wrench;  // bodies: force and moment about the centre of mass that act now
};

// What bodies received from outside, lost and did in a step or an interval.
struct SpatialBooks {
  Vec3 outside_N_s{0, 0, 0};
  double damping_J = 0, exciter_J = 0, reaction_J = 0, pushed_J = 0;
};

class SpatialBodies {
 public:
  SpatialBodies(SpatialParts parts, SpatialState state)
      : parts_(std::move(parts)), now_(state), coming_exciter_N_(3 * parts_.exciters()) {}

  std::size_t bodies() const { return parts_.bodies(); }
  std::size_t exciters() const { return parts_.exciters(); }
  std::size_t carried() const { return parts_.carried.size(); }

  // Takes over the coordinates and rates (bodies, 6) at t = 0, as the start.
  void start(const double *coordinates, const double *rates) {
    exciter_forces(0.0, now_.exciter_N);
    place(coordinates, rates);
    pull();
    std::copy_n(now_.couple_N_m, 3 * bodies(), now_.couple_before_N_m);
  }

  // The force and moment (bodies, 6) of forces on the carried points.  The lever arms are
  // extrapolated to the middle of the interval.
  void wrench_of(const double *force_N, double length_s, double *wrench) const {
    std::fill_n(wrench, 6 * bodies(), 0.0);
    for (std::size_t n = 0; n < carried(); ++n) {
      const int body = parts_.carried.body[n];
      if (body < 0) continue;
      Vec3 arm = times(now_.rotation, body, row(parts_.carried.arm_m.data(), n));
      arm = arm + length_s / 2 * cross(row(now_.spin_rad_per_s, body), arm);
      const Vec3 force = row(force_N, n);
      add(wrench, 2 * body, force);
      add(wrench, 2 * body + 1, cross(arm, force));
    }
  }

  // Takes over a wrench; its change over the mass is added to the accelerations of free bodies.
  void apply(const double *wrench, double *acceleration) {
    for (std::size_t b = 0; b < bodies(); ++b) {
      if (!parts_.is_free[b]) continue;
      const Vec3 force = row(wrench, 2 * b) - row(now_.wrench, 2 * b);
      const Vec3 moment = row(wrench, 2 * b + 1) - row(now_.wrench, 2 * b + 1);
      add(acceleration, 2 * b, 1.0 / parts_.mass_kg[b] * force);
      // moment = R I R' G times the angles' second derivatives
      const Vec3 turned = transposed_times(now_.rotation, b, moment);
      const Vec3 spun = times(now_.rotation, b, solved(parts_.inertia_kg_m2.data() + 9 * b, turned));
      add(acceleration, 2 * b + 1, solved(now_.spin_per_rate + 9 * b, spun));
    }
    std::copy_n(wrench, 6 * bodies(), now_.wrench);
  }

  // The loads at the end of the coming step: the exciters' forces, and torques with the bushings'
  // couples, which are extrapolated there.
  void coming_loads(double end_s, double *exciter_N, double *torque_N_m) {
    exciter_forces(end_s, coming_exciter_N_.data());
    std::copy(coming_exciter_N_.begin(), coming_exciter_N_.end(), exciter_N);
    for (std::size_t b = 0; b < bodies(); ++b)
      put(torque_N_m, b,
          row(now_.wrench, 2 * b + 1) + 2.0 * row(now_.couple_N_m, b) - row(now_.couple_before_N_m, b));
  }

  // Takes over the coordinates and rates at the end of the step whose loads came last: the motion and
  // the stretches, but not yet the bushings' forces.
  void reach(const double *coordinates, const double *rates) {
    const std::size_t bushings = parts_.bushings();
    stretch_.assign(now_.stretch_m, now_.stretch_m + 3 * bushings);
    stretching_.assign(now_.stretch_m_per_s, now_.stretch_m_per_s + 3 * bushings);
    pull_.assign(now_.pull_N, now_.pull_N + 3 * bushings);
    from_.assign(now_.from_m, now_.from_m + 3 * bushings);
    to_.assign(now_.to_m, now_.to_m + 3 * bushings);
    exciter_.assign(now_.exciter_N, now_.exciter_N + 3 * exciters());
    excited_.assign(now_.exciter_m, now_.exciter_m + 3 * exciters());
    spin_.assign(now_.spin_rad_per_s, now_.spin_rad_per_s + 3 * bodies());
    std::copy_n(now_.couple_N_m, 3 * bodies(), now_.couple_before_N_m);
    std::copy(coming_exciter_N_.begin(), coming_exciter_N_.end(), now_.exciter_N);
    place(coordinates, rates);
  }

  // Computes the bushings' forces there, with `element_N`, and returns the books of the step: the mean
  // of the forces at its two ends gives its impulse to rounding.
  SpatialBooks book(double step_s) {
    pull();
    return booked(step_s);
  }

  // The motion of the carried points, (n, 3) each.
  void carry(double *position_m, double *velocity_m_per_s) const {
    for (std::size_t n = 0; n < carried(); ++n) {
      const auto [place_m, m_per_s] = motion(parts_.carried, n);
      put(position_m, n, place_m);
      put(velocity_m_per_s, n, m_per_s);
    }
  }

  // The books of a reaction (n, 3) on the carried points, which moved meanwhile.
  SpatialBooks reaction(const double *force_N, const double *before_m, const double *after_m,
                        double length_s) const {
    SpatialBooks books;
    for (std::size_t n = 0; n < carried(); ++n) {
      const int body = parts_.carried.body[n];
      const Vec3 force = row(force_N, n);
      const double work_J = dot(force, row(after_m, n) - row(before_m, n));
      books.reaction_J += work_J;
      if (body < 0 || !parts_.is_free[body]) books.outside_N_s = books.outside_N_s - length_s * force;
      if (body >= 0 && parts_.is_driven[body]) books.pushed_J += work_J;
    }
    return books;
  }

 private:
  std::ptrdiff_t row_of(int body) const { return body < 0 ? parts_.bodies() : body; }

  std::pair<Vec3, Vec3> motion(const AttachedPoints &points, std::size_t n) const {
    const std::ptrdiff_t body = row_of(points.body[n]);
    const Vec3 arm = times(now_.rotation, body, row(points.arm_m.data(), n));
    return {row(now_.center_m, body) + arm,
            row(now_.velocity_m_per_s, body) + cross(row(now_.spin_rad_per_s, body), arm)};
  }

  // By Cramer's rule, for matrices far from singular.
  static Vec3 solved(const double *matrix, Vec3 right) {
    const Vec3 a = row(matrix, 0), b = row(matrix, 1), c = row(matrix, 2);
    const Vec3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    return 1.0 / dot(a, bc) * (right.x * bc + right.y * ca + right.z * ab);
  }

  // The inertia force of each exciter: mass moment times (phi'^2 radial - phi'' tangent).
  void exciter_forces(double time_s, double *force_N) const {
    for (std::size_t n = 0; n < exciters(); ++n) {
      const double full = parts_.speed_rad_per_s[n], run_up_s = parts_.run_up_s[n];
      const double stop_s = parts_.stop_s[n], run_down_s = parts_.run_down_s[n];
      double since_s = std::min(time_s, stop_s) - parts_.start_s[n];
      double angle = parts_.phase_rad[n], speed = 0.0, growth = 0.0;
      if (since_s >= run_up_s) {  // full speed
        angle += full * (since_s - run_up_s / 2);
        speed = full;
      } else if (run_up_s > 0) {  // a smooth run-up
        since_s = std::max(since_s, 0.0);
        const double rate = M_PI / run_up_s;
        angle += full / 2 * (since_s - std::sin(rate * since_s) / rate);
        speed = full / 2 * (1 - std::cos(rate * since_s));
        growth = full / 2 * rate * std::sin(rate * since_s);
      }
      if (time_s > stop_s) {  // a run-down that mirrors the run-up, then standstill
        speed = growth = 0.0;
        if (run_down_s > 0) {
          const double rate = M_PI / run_down_s, falling_s = std::min(time_s - stop_s, run_down_s);
          angle += full / 2 * (falling_s + std::sin(rate * falling_s) / rate);
          speed = full / 2 * (1 + std::cos(rate * falling_s));
          growth = -full / 2 * rate * std::sin(rate * falling_s);
        }
      }
      const Vec3 start = row(parts_.start.data(), n), across = row(parts_.across.data(), n);
      const double c = std::cos(angle), s = std::sin(angle);
      const Vec3 radial = c * start + s * across, tangent = c * across - s * start;
      put(force_N, n, parts_.mass_moment_kg_m[n] * (speed * speed * radial - growth * tangent));
    }
  }

  // Poses and stretches from displacements with Tait-Bryan angles (rotation Rx Ry Rz), and their rates.
  void place(const double *coordinates, const double *rates) {
    for (std::size_t b = 0; b < bodies(); ++b) {
      put(now_.center_m, b, row(parts_.drawn_m.data(), b) + row(coordinates, 2 * b));
      put(now_.velocity_m_per_s, b, row(rates, 2 * b));
      const Vec3 angle = row(coordinates, 2 * b + 1);
      const double sx = std::sin(angle.x), sy = std::sin(angle.y), sz = std::sin(angle.z);
      const double cx = std::cos(angle.x), cy = std::cos(angle.y), cz = std::cos(angle.z);
      double *rotation = now_.rotation + 9 * b, *axes = now_.spin_per_rate + 9 * b;
      put(rotation, 0, {cy * cz, -cy * sz, sy});
      put(rotation, 1, {cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy});
      put(rotation, 2, {sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy});
      put(axes, 0, {1.0, 0.0, sy});
      put(axes, 1, {0.0, cx, -sx * cy});
      put(axes, 2, {0.0, sx, cx * cy});
      put(now_.spin_rad_per_s, b, times(now_.spin_per_rate, b, row(rates, 2 * b + 1)));
    }
    for (std::size_t n = 0; n < exciters(); ++n) put(now_.exciter_m, n, motion(parts_.excited, n).first);
    for (std::size_t n = 0; n < parts_.bushings(); ++n) stretch(n);
  }

  // The stretch of bushing `n`, whose spring axes turn with its first body.
  void stretch(std::size_t n) {
    const auto [from_m, from_m_per_s] = motion(parts_.first, n);
    const auto [to_m, to_m_per_s] = motion(parts_.second, n);
    const std::ptrdiff_t body = row_of(parts_.first.body[n]);
    const auto along = [&](Vec3 v) {
      return times(parts_.axes.data(), n, transposed_times(now_.rotation, body, v));
    };
    put(now_.from_m, n, from_m);
    put(now_.to_m, n, to_m);
    put(now_.stretch_m, n, along(to_m - from_m) + row(parts_.sag_m.data(), n));
    put(now_.stretch_m_per_s, n, along(to_m_per_s - from_m_per_s));
  }

  // The forces of the bushings, and the couples that they add to their first bodies.
  void pull() {
    std::fill_n(now_.couple_N_m, 3 * bodies(), 0.0);
    for (std::size_t n = 0; n < parts_.bushings(); ++n) {
      const std::ptrdiff_t body = row_of(parts_.first.body[n]);
      const Vec3 along = scaled(parts_.stiffness_N_per_m.data(), n, row(now_.stretch_m, n)) +
                        scaled(parts_.damping_N_s_per_m.data(), n, row(now_.stretch_m_per_s, n)) +
                        row(now_.element_N, n);
      const Vec3 pull = times(now_.rotation, body, transposed_times(parts_.axes.data(), n, along));
      const Vec3 apart_m = row(now_.to_m, n) - row(now_.from_m, n);
      put(now_.pull_N, n, pull);
      if (parts_.first.body[n] >= 0) add(now_.couple_N_m, body, cross(apart_m, pull));
    }
  }

  // The books of the step to now, from what was kept of its start.
  SpatialBooks booked(double step_s) const {
    SpatialBooks books;
    Vec3 outside_N{0, 0, 0};
    for (std::size_t n = 0; n < parts_.bushings(); ++n) {
      const Vec3 pull = 0.5 * (row(pull_.data(), n) + row(now_.pull_N, n));
      const double from_J = dot(pull, row(now_.from_m, n) - row(from_.data(), n));
      const double to_J = dot(pull, row(now_.to_m, n) - row(to_.data(), n));
      const int first = parts_.first.body[n], second = parts_.second.body[n];
      outside_N = outside_N + (is(parts_.is_free, first) - is(parts_.is_free, second)) * pull;
      books.pushed_J += is(parts_.is_driven, first) * from_J - is(parts_.is_driven, second) * to_J;
      const Vec3 mean = 0.5 * (row(stretching_.data(), n) + row(now_.stretch_m_per_s, n));
      const Vec3 moved = row(now_.stretch_m, n) - row(stretch_.data(), n);
      books.damping_J += dot(scaled(parts_.damping_N_s_per_m.data(), n, mean), moved);
    }
    for (std::size_t n = 0; n < exciters(); ++n) {
      const Vec3 force = 0.5 * (row(exciter_.data(), n) + row(now_.exciter_N, n));
      outside_N = outside_N + force;
      books.exciter_J += dot(force, row(now_.exciter_m, n) - row(excited_.data(), n));
    }
    const Vec3 gravity = row(parts_.gravity_m_per_s2.data(), 0);
    for (std::size_t b = 0; b < bodies(); ++b) {
      if (parts_.is_free[b]) outside_N = outside_N + parts_.mass_kg[b] * gravity;
      if (!parts_.is_driven[b]) continue;
      const Vec3 couple = row(now_.couple_before_N_m, b) + row(now_.couple_N_m, b);
      books.pushed_J += step_s / 4 * dot(couple, row(spin_.data(), b) + row(now_.spin_rad_per_s, b));
    }
    books.outside_N_s = step_s * outside_N;
    return books;
  }

  static double is(const std::vector<int> &flags, int body) { return body >= 0 && flags[body] ? 1.0 : 0.0; }

  SpatialParts parts_;
  SpatialState now_;
  std::vector<double> coming_exciter_N_;
  // at the start of the step that is booked
  std::vector<double> stretch_, stretching_, pull_, from_, to_, exciter_, excited_, spin_;
};

}  // namespace flipflow
