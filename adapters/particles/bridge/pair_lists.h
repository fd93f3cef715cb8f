#pragma once

#include <vector>

#include "neigh_list.h"
#include "neighbor.h"

#include "../../vec3.h"
#include "fix_bodies.h"

namespace flipflow {

// LIGGGHTS's lists of neighbours, made in another way: the same pairs with the same histories, but the
// neighbours of a particle come in another order.
//
// LIGGGHTS follows a chain of particles in each of a hundred small bins around every particle.  Here copies
// of the particles lie in memory in the order of their cells, so that the neighbours of a particle are among
// a few short rows of copies.
class PairLists : public LAMMPS_NS::Neighbor {
 public:
  using Neighbor::Neighbor;

  // Spheres of one body are no neighbours.
  void know(const FixBodies *bodies) { bodies_ = bodies; }

 private:
  struct Copy {
    Vec3 position_m;
    double radius_m;
  };

  void choose_build(int index, LAMMPS_NS::NeighRequest *request) override;
  void list_pairs(LAMMPS_NS::NeighList *list);
  void lay_out_cells(int particles, double reach_m);
  void sort_into_cells(int particles);
  int cell_at(const double *place_m) const;
  int find_neighbours(int particle);
  int without_own_body(int particle, int count);
  void recall_histories(LAMMPS_NS::NeighList &list, int particle, int neighbours) const;

  double low_m_[3], cell_m_[3];
  int count_[3];
  std::vector<int> cell_, first_, number_;  // each particle's cell, each cell's first copy, each copy's number
  std::vector<Copy> copies_;
  const FixBodies *bodies_ = nullptr;  // null: particles are single spheres
  std::vector<int> neighbours_;  // of one particle
};

}  // namespace flipflow
