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

constexpr double kCellsPerParticle = 64.0;  // at most, besides the frame: all are cleared for every list

// As many cells are as long as the farthest neighbour is far.  They are short along x, in which they follow each
// other in memory: short cells there make short rows, elsewhere they would make many.
constexpr int kFarthest[3] = {4, 1, 1};

}  // namespace

void PairLists::choose_build(int index, NeighRequest *request) {
  Neighbor::choose_build(index, request);
  if (pair_build[index] == &PairLists::granular_bin_no_newton)
    pair_build[index] = static_cast<PairPtr>(&PairLists::list_pairs);
}

// A pair of own particles is listed with the first of them, a pair with a ghost on both ranks.
void PairLists::list_pairs(NeighList *list) {
  const int all = atom->nlocal + atom->nghost;
  const double largest_m = all > 0 ? *std::max_element(atom->radius, atom->radius + all) : 0.0;
  lay_out_cells(all, 2.0 * largest_m * contactDistanceFactor + skin);
  sort_into_cells(all);
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

// The cells cover all particles, within a frame of empty ones.
void PairLists::lay_out_cells(int particles, double reach_m) {
  double size_m[3];
  for (int d = 0; d < 3; ++d) {
    double low_m = INFINITY, high_m = -INFINITY;
    for (int i = 0; i < particles; ++i) {
      low_m = std::min(low_m, atom->x[i][d]);
      high_m = std::max(high_m, atom->x[i][d]);
    }
    low_m_[d] = low_m;
    size_m[d] = std::isfinite(high_m - low_m) ? high_m - low_m : 0.0;  // who is nowhere is found elsewhere
    cell_m_[d] = reach_m / kFarthest[d];
  }
  const auto along = [&](int d) { return std::floor(size_m[d] / cell_m_[d]) + 1.0; };
  while (along(0) * along(1) * along(2) > kCellsPerParticle * particles + 1.0)
    for (double &cell_m : cell_m_) cell_m *= 1.25;
  for (int d = 0; d < 3; ++d) count_[d] = static_cast<int>(along(d)) + 2 * kFarthest[d];
}

int PairLists::cell_at(const double *place_m) const {
  int cell = 0;
  for (int d = 2; d >= 0; --d) {
    const double along = std::max(0.0, (place_m[d] - low_m_[d]) / cell_m_[d]);  // 0 where it is no number
    const double last = count_[d] - 2 * kFarthest[d] - 1;
    cell = cell * count_[d] + kFarthest[d] + static_cast<int>(std::min(along, last));
  }
  return cell;
}

void PairLists::sort_into_cells(int particles) {
  cell_.resize(particles);
  number_.resize(particles);
  copies_.resize(particles);
  neighbours_.resize(particles + 1);
  first_.assign(static_cast<size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
  for (int i = 0; i < particles; ++i) ++first_[cell_[i] = cell_at(atom->x[i])];
  int end = 0;
  for (int &first : first_) first = end += first;  // now one past each cell's last
  for (int i = particles; i-- > 0;) {
    const int copy = --first_[cell_[i]];
    number_[copy] = i;
    copies_[copy] = {from(atom->x[i]), atom->radius[i]};
  }
}

// Fills `neighbours_` with the particles of higher number that are, less skin, no farther than contacts reach,
// and returns their number.  There is no branch: that would depend on what no processor foresees.
int PairLists::find_neighbours(int i) {
  const Vec3 here = from(atom->x[i]);
  const double radius_m = atom->radius[i];
  int found = 0;
  for (int z = -kFarthest[2]; z <= kFarthest[2]; ++z)
    for (int y = -kFarthest[1]; y <= kFarthest[1]; ++y) {
      const int *middle = &first_[cell_[i] + (z * count_[1] + y) * count_[0]];
      for (int copy = middle[-kFarthest[0]]; copy < middle[kFarthest[0] + 1]; ++copy) {
        const Vec3 apart_m = here - copies_[copy].position_m;
        const double reach_m = (radius_m + copies_[copy].radius_m) * contactDistanceFactor + skin;
        neighbours_[found] = number_[copy];
        found += (number_[copy] > i) & (dot(apart_m, apart_m) <= reach_m * reach_m);
      }
    }
  return found;
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
