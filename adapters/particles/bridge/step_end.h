#pragma once

#include <algorithm>

#include "contact_models.h"

#include "../../vec3.h"

namespace flipflow {

// Lets the dampers of a contact go by the velocities of the end of the step, where velocity Verlet evaluates
// forces while its velocities are still those of the middle.
//
// In half a step a contact's own force F changes its slip by  h F / 2m,  with the damper's part in F by the later
// slip itself:  dv = h / 2m (F_elastic - c (v + dv)),  along the normal with the reduced mass, across it with 2/7 of
// it, as spheres turn.  No damper overshoots by that, however strong it is.  But others push, too: of that change,
// only the share is taken that the slip has shown from the middle of the last step to that of this one, from none
// (a contact at rest) to all (an impact).
//
// The history of a contact keeps its slip in the last evaluation, and what share of the change since then is half a
// step: 1/2 after a step, 1 after an evaluation between steps, 0 of a contact that is new.
class StepEnd {
  using Touching = LIGGGHTS::ContactModels::SurfacesIntersectData;
  using Close = LIGGGHTS::ContactModels::SurfacesCloseData;

 public:
  // What the contact's springs and dampers give: along the normal a force that pushes apart, and stiffness and
  // damping across it.
  struct Law {
    double elastic_N, damping_N_s_per_m, shear_N_per_m, shear_damping_N_s_per_m;
  };

  explicit StepEnd(LIGGGHTS::IContactHistorySetup *history) : slip_(history->add_history_value("slipx", "1")) {
    history->add_history_value("slipy", "1");
    history->add_history_value("slipz", "1");
    history->add_history_value("half_step", "0");
  }

  // Calls the contact model with the slip of the step's end.  `spring`: where the tangential spring is in the
  // history, -1 without one; it goes by the middle's slip, by which the bodies moved.
  template <class Model>
  void apply(Touching &pair, const Law &law, int spring, double step_s, Model model) const {
    double *const history = pair.contact_history, *const v_i = pair.v_i, *const v_j = pair.v_j;
    const bool in_a_step = pair.computeflag && pair.shearupdate;
    const Vec3 slip = slip_of(pair), shown = history[slip_ + 3] * (slip - from(history + slip_));
    put(history + slip_, slip);
    history[slip_ + 3] = in_a_step ? 0.5 : 1.0;
    if (!in_a_step) return between_steps(history, spring, model);
    if (law.damping_N_s_per_m == 0.0) return model();
    const Vec3 n = from(pair.en);
    const double half = 0.5 * step_s / pair.meff, along = dot(slip, n);
    Vec3 ahead = share(own(half, law.damping_N_s_per_m, law.elastic_N * n, along * n), shown);
    if (spring >= 0) {
      double *const stretch = history + spring;
      const Vec3 slides = slip - along * n, trial = from(stretch) + step_s * slides;
      const Vec3 pull = -law.shear_N_per_m * (trial - dot(trial, n) * n);
      const Vec3 across = share(own(3.5 * half, law.shear_damping_N_s_per_m, pull, slides), shown);
      ahead = ahead + across;
      add_to(stretch, -step_s * across);  // which the model adds
    }
    double end_i[3], end_j[3];  // half of it to each, so that a pair seen from its other side is the same to the bit
    put(end_i, from(v_i) + 0.5 * ahead);
    put(end_j, from(v_j) - 0.5 * ahead);
    pair.v_i = end_i;
    pair.v_j = end_j;
    model();
    pair.v_i = v_i;
    pair.v_j = v_j;
  }

  // The history of a pair that LIGGGHTS does not list as touching is not to be written to.
  void forget(const Close &pair) const {
    if (pair.contact_history && pair.contact_history[slip_ + 3] > 0.0) pair.contact_history[slip_ + 3] = 0.0;
  }

  // Of body i against j at the contact's plane, as LIGGGHTS's surface model has it.
  static Vec3 slip_of(const Touching &pair) {
    const double half = 0.5 * (pair.is_wall ? pair.deltan : pair.radsum - pair.r);
    Vec3 rolled = (pair.radi - half) * from(pair.omega_i);
    if (!pair.is_wall) rolled = rolled + (pair.radj - half) * from(pair.omega_j);
    return from(pair.v_i) - from(pair.v_j) + pair.rinv * cross(from(pair.delta), rolled);
  }

 private:
  // Velocities are those of now, and nothing moves.  The spring of a contact that slid is at the limit of friction,
  // to rounding: it slides on, on both sides of a pair that two ranks or two periodic sides see.
  template <class Model>
  static void between_steps(double *history, int spring, Model model) {
    if (spring < 0) return model();
    const Vec3 stretch = from(history + spring);
    put(history + spring, (1.0 + kRounding) * stretch);
    model();
    put(history + spring, stretch);
  }

  static Vec3 own(double half, double damping, Vec3 elastic, Vec3 slip) {
    return half / (1.0 + half * damping) * (elastic - damping * slip);
  }

  static Vec3 share(Vec3 own, Vec3 shown) {
    const double all = dot(own, own);
    return all > 0.0 ? std::clamp(dot(shown, own) / all, 0.0, 1.0) * own : own;
  }

  static constexpr double kRounding = 1e-9;  // of a force, more than places far from the origin let it have

  int slip_;
};

}  // namespace flipflow
