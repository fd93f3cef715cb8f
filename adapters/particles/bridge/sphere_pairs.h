#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "atom.h"
#include "error.h"
#include "force.h"
#include "granular_pair_style.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "settings.h"

#include "../../vec3.h"
#include "deepest_overlap.h"
#include "shared_contacts.h"

namespace flipflow {

// The loop over listed pairs of a contact model of LIGGGHTS, in place of its PairStyles::Granular: the same
// pairs meet the same model in the same order, to the bit.  LIGGGHTS prepares every listed pair for the model
// and asks it for effects that no run of flipflow has (rigid and frozen bodies, stored forces, virials); most
// pairs do not touch.  Here a pair costs more than its distance only if it touches, or did so and has a
// history to forget.  It also keeps the deepest overlap of all steps.
//
// Where particles are spheres of bodies, all who meet are found before the first of them do: bodies may touch
// with several spheres at once, and the masses by which contacts are damped follow from all of these.
template <class Model>
class SpherePairs : public LIGGGHTS::PairStyles::IGranularPairStyle {
 public:
  SpherePairs(LAMMPS_NS::LAMMPS *lmp, LAMMPS_NS::PairGran *style, int64_t hash)
      : lmp_(*lmp), model_(lmp, style, false, hash), deepest_(deepest_between[lmp]) {}

  int64_t hashcode() override { return model_.hashcode(); }
  double stressStrainExponent() override { return model_.stressStrainExponent(); }
  int get_history_offset(const std::string name) override { return model_.get_history_offset(name); }
  bool contact_match(const std::string type, const std::string model) override {
    return model_.contact_match(type, model);
  }
  void write_restart_settings(std::FILE *) override {}  // LIGGGHTS writes none
  void read_restart_settings(std::FILE *, int64_t) override {}

  void settings(int words, char **word, LIGGGHTS::IContactHistorySetup *history) override {
    Settings known(&lmp_);
    model_.registerSettings(known);
    const bool understood = known.parseArguments(words, word);
    model_.postSettings(history);
    if (!understood) lmp_.error->all(FLERR, known.error_message.c_str());
  }

  void init_granular() override { model_.connectToProperties(lmp_.force->registry); }

  void compute_force(LAMMPS_NS::PairGran *style, int, int, int) override {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    const LAMMPS_NS::NeighList &list = *style->list, *histories = style->listgranhistory;
    style->evflag = style->vflag_fdotr = 0;
    histories_.resize(met_);
    met_ = 0;
    pair_ = {};
    pair_.computeflag = style->computeflag();
    pair_.shearupdate = style->shearupdate();
    const auto bodies = bodies_of.find(&lmp_);
    bodies_ = bodies == bodies_of.end() ? nullptr : bodies->second;
    for (int k = 0; k < list.inum; ++k) {
      const int i = list.ilist[k];
      const int meet = find_whom_to_meet(i, list.firstneigh[i], list.numneigh[i],
                                         histories ? histories->firstneigh[i] : nullptr);
      for (int m = 0; m < meet; ++m) {
        const int n = to_meet_[m], j = list.firstneigh[i][n] & NEIGHMASK;
        if (bodies_)
          note(i, j, n);
        else
          this->meet(*style, i, j, n, atom.rmass[i] * atom.rmass[j] / (atom.rmass[i] + atom.rmass[j]));
      }
    }
    if (bodies_) meet_as_bodies(*style);
  }

 private:
  // Spheres of two bodies that are to meet; `n` is the place of j in the list of i.
  struct Meeting {
    int i, j, n;
    int shared;            // number of the contacts of these two bodies; kNone: the spheres do not touch
    double stiffness;      // up to a factor that all contacts of two bodies share
    double reduced_kg, own_kg;  // own: by which the contact is damped if it is the only one
  };
  // The contacts of the body of sphere i, which is one of this rank, with that of sphere j.
  struct Shared {
    int i, j, next;  // next: of the same body with others; kNone: the last
    SharedContacts contacts;
  };
  static constexpr int kNone = -1;

  void note(int i, int j, int n) {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    const Vec3 apart = from(atom.x[i]) - from(atom.x[j]);
    const double distance = norm(apart), sum = atom.radius[i] + atom.radius[j];
    const Vec3 normal = (1.0 / distance) * apart;
    SharedContacts::Contact contact = {normal, bodies_->moment_about_centre(i, normal),
                                       bodies_->moment_about_centre(j, normal), 0.0,
                                       dot(from(atom.v[i]) - from(atom.v[j]), normal)};
    const double light = 1.0 / atom.rmass[i] + 1.0 / atom.rmass[j];
    const double turning = bodies_->turns_per(i, contact.turned) + bodies_->turns_per(j, contact.other_turned);
    meetings_.push_back({i, j, n, kNone, 0.0, 1.0 / light, 1.0 / (light + turning)});
    if (distance >= sum) return;
    Meeting &meeting = meetings_.back();
    meeting.stiffness = contact.stiffness =
        std::sqrt(atom.radius[i] * atom.radius[j] / sum * (sum - distance));
    meeting.shared = find_shared(i, j);
    Shared &shared = shared_[meeting.shared];
    if (!bodies_->same_body(i, shared.i)) {
      contact.normal = -1.0 * normal;
      contact.turned = -1.0 * std::exchange(contact.other_turned, -1.0 * contact.turned);
    }
    shared.contacts.add(contact);
  }

  // One with a body from next door is not one with a body of this rank, though across a periodic side it may be
  // the same: that contact comes twice.
  int find_shared(int i, int j) {
    const int nlocal = lmp_.atom->nlocal;
    if (j < nlocal && bodies_->lead_of_atom(j) < bodies_->lead_of_atom(i)) std::swap(i, j);
    first_shared_.resize(nlocal, kNone);
    int &first = first_shared_[bodies_->lead_of_atom(i)];
    for (int s = first; s != kNone; s = shared_[s].next)
      if (bodies_->same_body(j, shared_[s].j) && (j < nlocal) == (shared_[s].j < nlocal)) return s;
    shared_.push_back({i, j, first, {}});
    return first = static_cast<int>(shared_.size()) - 1;
  }

  void meet_as_bodies(LAMMPS_NS::PairGran &style) {
    for (const Meeting &of : meetings_) meet(style, of.i, of.j, of.n, damped_kg(of));
    for (const Shared &of : shared_) first_shared_[bodies_->lead_of_atom(of.i)] = kNone;
    shared_.clear();
    meetings_.clear();
  }

  double damped_kg(const Meeting &of) const {
    if (of.shared == kNone || shared_[of.shared].contacts.number() == 1) return of.own_kg;
    const Shared &shared = shared_[of.shared];
    return shared.contacts.mass_kg(of.stiffness, of.reduced_kg, [&](Vec3 turned, Vec3 other_turned) {
      return bodies_->turns_per(shared.i, turned) + bodies_->turns_per(shared.j, other_turned);
    });
  }

  // Fills `to_meet_` with the places in the list of those who touch the particle, or did so, and returns their
  // number.  There is no branch: that would depend on what no processor foresees.
  int find_whom_to_meet(int i, const int *other, int count, const int *flags) {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    const double factor = lmp_.neighbor->contactDistanceFactor;
    const Vec3 here = from(atom.x[i]);
    if (static_cast<int>(to_meet_.size()) < count) {
      to_meet_.resize(count);
      untouched_.resize(count);
    }
    const int *const touched = flags ? flags : untouched_.data();
    int meet = 0;
    for (int n = 0; n < count; ++n) {
      const int j = other[n] & NEIGHMASK;
      const Vec3 apart = here - from(atom.x[j]);
      const double reach = atom.radius[i] + atom.radius[j], distance2 = dot(apart, apart);
      const bool touches = distance2 < reach * reach;
      const bool forgets = (touched[n] != 0) & (distance2 < factor * factor * reach * reach);
      to_meet_[meet] = n;
      meet += touches | forgets;
    }
    return meet;
  }

  void meet(LAMMPS_NS::PairGran &style, int i, int j, int n, double damped_kg) {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    const LAMMPS_NS::NeighList *histories = style.listgranhistory;
    pair_.i = i;
    pair_.itype = atom.type[i];
    pair_.radi = atom.radius[i];
    pair_.mi = atom.rmass[i];
    pair_.v_i = atom.v[i];
    pair_.omega_i = atom.omega[i];
    pair_.contact_flags = histories ? histories->firstneigh[i] + n : nullptr;
    pair_.contact_history = histories ? histories->firstdouble[i] + style.dnum() * n : nullptr;
    put(pair_.delta, from(atom.x[i]) - from(atom.x[j]));
    pair_.rsq = dot(from(pair_.delta), from(pair_.delta));
    pair_.j = j;
    pair_.jtype = atom.type[j];
    pair_.radj = atom.radius[j];
    pair_.radsum = pair_.radi + pair_.radj;
    pair_.meff = damped_kg;
    pair_.v_j = atom.v[j];
    remember(pair_.contact_history);
    on_i_.reset();
    on_j_.reset();
    pair_.has_force_update = pair_.rsq < pair_.radsum * pair_.radsum;
    if (pair_.has_force_update) {
      pair_.r = std::sqrt(pair_.rsq);
      pair_.rinv = 1.0 / pair_.r;
      put(pair_.en, pair_.rinv * from(pair_.delta));
      pair_.mj = atom.rmass[j];
      pair_.omega_j = atom.omega[j];
      model_.surfacesIntersect(pair_, on_i_, on_j_);  // which sets the overlap
      model_.endSurfacesIntersect(pair_, nullptr, on_i_, on_j_);
      deepest_.add(pair_.deltan, std::min(pair_.radi, pair_.radj));
    } else {
      model_.surfacesClose(pair_, on_i_, on_j_);
    }
    if (!pair_.has_force_update || !pair_.computeflag) return;
    add(on_i_, pair_.i);
    if (j < atom.nlocal) add(on_j_, j);
  }

  void add(const LIGGGHTS::ContactModels::ForceData &forces, int particle) const {
    add_to(lmp_.atom->f[particle], from(forces.delta_F));
    add_to(lmp_.atom->torque[particle], from(forces.delta_torque));
  }

  // Remembers a contact's history for the next step, and asks memory for one that comes soon: a large bed's
  // do not stay near the processor from step to step, and a step meets nearly the same ones as the last.
  void remember(const double *history) {
    if (met_ + kAhead < histories_.size()) {
      const double *soon = histories_[met_ + kAhead];  // where there is none any more, nothing happens
      __builtin_prefetch(soon);
      __builtin_prefetch(soon + kValues - 1);
    }
    if (met_ == histories_.size()) histories_.push_back(history);
    histories_[met_++] = history;
  }

  static constexpr size_t kAhead = 16;  // contacts
  static constexpr int kValues = 12;    // of a history at most

  LAMMPS_NS::LAMMPS &lmp_;
  Model model_;
  DeepestOverlap &deepest_;
  LIGGGHTS::ContactModels::SurfacesIntersectData pair_;
  LIGGGHTS::ContactModels::ForceData on_i_, on_j_;
  std::vector<int> to_meet_, untouched_;   // as many as the longest list has
  const FixBodies *bodies_ = nullptr;
  std::vector<Meeting> meetings_;
  std::vector<Shared> shared_;
  std::vector<int> first_shared_;          // of each body, with its first sphere
  std::vector<const double *> histories_;  // of the last step's contacts, in their order
  size_t met_ = 0;
};

}  // namespace flipflow
