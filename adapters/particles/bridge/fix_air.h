#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "atom.h"
#include "fix.h"
#include "update.h"

#include "../../vec3.h"
#include "fix_bodies.h"
#include "saved_state.h"

namespace flipflow {

// Still air, which resists every particle by its own speed.  The drag coefficient of a sphere is
// 24 / Re (1 + 0.15 Re^0.687) (L. Schiller and A. Naumann, Z. Ver. Dtsch. Ing. 77 (1933) 318-320), and no
// less than 0.44, which it is from Re = 1e3 to the drag crisis at 2e5.
//
// `fix air all air/flipflow <density> <viscosity>`, behind all other forces.
class FixAir : public LAMMPS_NS::Fix {
 public:
  FixAir(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg)
      : Fix(lmp, narg, arg), density_kg_per_m3_(std::atof(arg[3])), viscosity_Pa_s_(std::atof(arg[4])) {}

  // A body has the drag of the sphere of its volume, at its centre.
  void know(const FixBodies *bodies) { bodies_ = bodies; }

  int setmask() override { return LAMMPS_NS::FixConst::POST_FORCE; }
  void setup(int flag) override { post_force(flag); }

  // Verlet's velocities are those of the middle of the step while forces are evaluated, between two runs
  // those of now.  The work of a force over Verlet's two half steps goes by the velocity of now, which the
  // sum of all forces gives.
  void post_force(int) override {
    const double step = update->setupflag ? 0.0 : update->dt;
    now_ = {};
    for (int b = 0; bodies_ && b < bodies_->count(); ++b) resist(b, step);
    for (int i = 0; !bodies_ && i < atom->nlocal; ++i) {
      const Vec3 v = from(atom->v[i]);
      const Vec3 drag = -resistance(2.0 * atom->radius[i], norm(v)) * v;
      add_to(atom->f[i], drag);
      const Vec3 v_now = v + (0.5 * step / atom->rmass[i]) * from(atom->f[i]);
      now_.add(1.0, {drag, cross(from(atom->x[i]), drag), dot(drag, v_now)});
    }
    given_.add(step, now_);
  }

  // The first and the last evaluation of a run act for half a step.
  void begin_sums(double step_s) { given_.add(0.5 * step_s, now_); }
  void end_sums(double step_s) { given_.add(-0.5 * step_s, now_); }

  // Since t = 0, of this rank's particles: impulse, its moment about the world's origin, and work.
  Vec3 impulse_N_s() const { return given_.force; }
  Vec3 angular_impulse_N_m_s() const { return given_.moment; }
  double work_J() const { return given_.power; }

  void save(SavedState &saved) const {
    auto &air = saved.reals["air"];
    for (const Sums &sums : {now_, given_}) {
      for (Vec3 of : {sums.force, sums.moment}) air.insert(air.end(), {of.x, of.y, of.z});
      air.push_back(sums.power);
    }
  }

  void restore(const SavedState &saved) {
    const double *air = saved.real("air").data();
    for (Sums *sums : {&now_, &given_}) {
      *sums = {from(air), from(air + 3), air[6]};
      air += 7;
    }
  }

 private:
  struct Sums {
    Vec3 force = {0, 0, 0}, moment = {0, 0, 0};
    double power = 0.0;

    void add(double share, const Sums &other) {
      force = force + share * other.force;
      moment = moment + share * other.moment;
      power += share * other.power;
    }
  };

  // On the first sphere of a body, with the couple that moves the force to the centre.
  void resist(int b, double step) {
    const FixBodies::Row &body = bodies_->row(b);
    const int lead = bodies_->lead(b);
    const Vec3 drag = -resistance(bodies_->equivalent_diameter_m(b), norm(body.velocity)) * body.velocity;
    const Vec3 without = bodies_->force_now_N(b);
    add_to(atom->f[lead], drag);
    add_to(atom->torque[lead], -1.0 * cross(from(atom->x[lead]) - body.place, drag));
    const Vec3 v_now = body.velocity + (0.5 * step / atom->rmass[lead]) * (without + drag);
    now_.add(1.0, {drag, cross(body.place, drag), dot(drag, v_now)});
  }

  // Drag over speed.
  double resistance(double diameter_m, double speed_m_per_s) const {
    const double stokes = 3.0 * M_PI * viscosity_Pa_s_ * diameter_m;
    const double re = density_kg_per_m3_ * speed_m_per_s * diameter_m / viscosity_Pa_s_;
    return stokes * std::max(1.0 + 0.15 * std::pow(re, 0.687), 0.44 / 24.0 * re);
  }

  double density_kg_per_m3_, viscosity_Pa_s_;
  const FixBodies *bodies_ = nullptr;
  Sums now_, given_;  // of the last evaluation; since t = 0
};

}  // namespace flipflow
