#include "pair_lists.h"

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "error.h"
#include "fix_contact_history.h"
#include "modify.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

constexpr int kMostClasses = 8;

}  // namespace

void PairLists::choose_build(int index, NeighRequest *request) {
  Neighbor::choose_build(index, request);
  if (pair_build[index] == &PairLists::granular_bin_no_newton)
    pair_build[index] = static_cast<PairPtr>(&PairLists::list_pairs);
}

// A pair of own particles is listed once, a pair with a ghost on both ranks.
void PairLists::list_pairs(NeighList *list) {
  sort_into_classes();
  if (modify->n_fixes_style("neighlist/mesh") > 0) bin_atoms();  // LIGGGHTS's own walls look there
  list->ipage->reset();
  if (list->fix_history) {
    list->listgranhistory->ipage->reset();
    list->listgranhistory->dpage->reset();
  }
  for (int i = 0; i < atom->nlocal; ++i) {
    int count = find_neighbours(i);
    if (bodies_) count = without_own_body(i, count);
    if (count > list->oneatom)
      error->one(FLERR, "a particle has more neighbours than LIGGGHTS lists for one: sizes differ too much");
    list->ilist[i] = i;
    list->numneigh[i] = count;
    list->firstneigh[i] = list->ipage->get(count);
    std::copy_n(neighbours_.begin(), count, list->firstneigh[i]);
    if (list->fix_history) recall_histories(*list, i, count);
  }
  list->inum = atom->nlocal;
}

void PairLists::sort_into_classes() {
  const int all = atom->nlocal + atom->nghost;
  const double largest_m = all > 0 ? *std::max_element(atom->radius, atom->radius + all) : 0.0;
  for (SizeClass &of : classes_) {
    of.numbers.clear();
    of.ghost_numbers.clear();
  }
  class_of_.resize(all);
  neighbours_.resize(all + 1);
  const double per_class = 1.0 / std::log(class_ratio_);
  for (int i = 0; i < all; ++i) {
    class_of_[i] = std::min(kMostClasses - 1, static_cast<int>(per_class * std::log(largest_m / atom->radius[i])));
    if (class_of_[i] >= static_cast<int>(classes_.size())) classes_.resize(class_of_[i] + 1);
    classes_[class_of_[i]].numbers.push_back(i);
    if (i >= atom->nlocal) classes_[class_of_[i]].ghost_numbers.push_back(i);
  }
  double class_m = 2.0 * largest_m;
  for (SizeClass &of : classes_) {
    const double usual_m = class_m * contactDistanceFactor + skin;
    of.all.sort(of.numbers, atom->x, atom->radius, usual_m);
    of.ghosts.sort(of.ghost_numbers, atom->x, atom->radius, usual_m);
    class_m /= class_ratio_;
  }
}

// Fills `neighbours_` with a particle's neighbours of its own class that have a higher number, with all of coarser
// classes and with the ghosts of finer ones, and returns their number.
int PairLists::find_neighbours(int i) {
  int *found = neighbours_.data();
  const auto look = [&](const Cells &cells, int above) {
    if (!cells.empty())
      found = cells.find(from(atom->x[i]), atom->radius[i], contactDistanceFactor, skin, above, found);
  };
  const int own = class_of_[i];
  look(classes_[own].all, i);
  for (int coarser = 0; coarser < own; ++coarser) look(classes_[coarser].all, -1);
  for (size_t finer = own + 1; finer < classes_.size(); ++finer) look(classes_[finer].ghosts, -1);
  return static_cast<int>(found - neighbours_.data());
}

// The number of neighbours that are left.  A body is whole on its rank, so no ghost belongs to it.
int PairLists::without_own_body(int i, int count) {
  const auto is_own = [&](int j) { return j < atom->nlocal && bodies_->same_body(i, j); };
  const auto first = neighbours_.begin();
  return static_cast<int>(std::remove_if(first, first + count, is_own) - first);
}

// A pair has the history of the contact that it had, unless it has come apart.
void PairLists::recall_histories(NeighList &list, int i, int neighbours) const {
  NeighList &kept = *list.listgranhistory;
  FixContactHistory &contacts = *list.fix_history;
  int *flags = kept.firstneigh[i] = kept.ipage->get(neighbours);
  double *values = kept.firstdouble[i] = kept.dpage->get(neighbours * kept.dnum);
  std::fill_n(flags, neighbours, 0);
  std::fill_n(values, neighbours * kept.dnum, 0.0);
  for (int n = 0; n < neighbours && contacts.n_partner(i) > 0; ++n) {
    const int j = neighbours_[n];
    const Vec3 apart_m = from(atom->x[i]) - from(atom->x[j]);
    const double reach_m = (atom->radius[i] + atom->radius[j]) * contactDistanceFactor;
    if (dot(apart_m, apart_m) >= reach_m * reach_m) continue;
    for (int m = 0; m < contacts.n_partner(i); ++m) {
      if (contacts.partner(i, m) != atom->tag[j]) continue;
      flags[n] = 1;
      contacts.contacthistory(i, m, values + n * kept.dnum);
      break;
    }
  }
}

}  // namespace flipflow
