#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
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

namespace flipflow {

// The loop over listed pairs of a contact model of LIGGGHTS, in place of its PairStyles::Granular: the same
// pairs meet the same model in the same order, to the bit.  LIGGGHTS prepares every listed pair for the model
// and asks it for effects that no run of flipflow has (rigid and frozen bodies, stored forces, virials); most
// pairs do not touch.  Here a pair costs more than its distance only if it touches, or did so and has a
// history to forget.  It also keeps the deepest overlap of all steps.
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
    for (int k = 0; k < list.inum; ++k) {
      const int i = pair_.i = list.ilist[k];
      pair_.itype = atom.type[i];
      pair_.radi = atom.radius[i];
      pair_.mi = atom.rmass[i];
      pair_.v_i = atom.v[i];
      pair_.omega_i = atom.omega[i];
      int *const flags = histories ? histories->firstneigh[i] : nullptr;
      const int meet = find_whom_to_meet(list.firstneigh[i], list.numneigh[i], flags);
      for (int m = 0; m < meet; ++m) {
        const int n = to_meet_[m];
        pair_.contact_flags = flags ? flags + n : nullptr;
        pair_.contact_history = flags ? histories->firstdouble[i] + style->dnum() * n : nullptr;
        this->meet(list.firstneigh[i][n] & NEIGHMASK);
      }
    }
  }

 private:
  // Fills `to_meet_` with the places in the list of those who touch the particle, or did so, and returns their
  // number.  There is no branch: that would depend on what no processor foresees.
  int find_whom_to_meet(const int *other, int count, const int *flags) {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    const double factor = lmp_.neighbor->contactDistanceFactor;
    const Vec3 here = from(atom.x[pair_.i]);
    if (static_cast<int>(to_meet_.size()) < count) {
      to_meet_.resize(count);
      untouched_.resize(count);
    }
    const int *const touched = flags ? flags : untouched_.data();
    int meet = 0;
    for (int n = 0; n < count; ++n) {
      const int j = other[n] & NEIGHMASK;
      const Vec3 apart = here - from(atom.x[j]);
      const double reach = pair_.radi + atom.radius[j], distance2 = dot(apart, apart);
      const bool touches = distance2 < reach * reach;
      const bool forgets = (touched[n] != 0) & (distance2 < factor * factor * reach * reach);
      to_meet_[meet] = n;
      meet += touches | forgets;
    }
    return meet;
  }

  void meet(int j) {
    const LAMMPS_NS::Atom &atom = *lmp_.atom;
    put(pair_.delta, from(atom.x[pair_.i]) - from(atom.x[j]));
    pair_.rsq = dot(from(pair_.delta), from(pair_.delta));
    pair_.j = j;
    pair_.jtype = atom.type[j];
    pair_.radj = atom.radius[j];
    pair_.radsum = pair_.radi + pair_.radj;
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
      pair_.meff = pair_.mi * pair_.mj / (pair_.mi + pair_.mj);
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
  std::vector<const double *> histories_;  // of the last step's contacts, in their order
  size_t met_ = 0;
};

}  // namespace flipflow
