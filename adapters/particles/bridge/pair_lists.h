#pragma once

#include <vector>

#include "neigh_list.h"
#include "neighbor.h"

#include "cells.h"
#include "fix_bodies.h"

namespace flipflow {

// LIGGGHTS's lists of neighbours, made in another way: the same pairs with the same histories, but the
// neighbours of a particle come in another order.
//
// LIGGGHTS follows a chain of particles in each of a hundred bins around every particle, and the largest particle
// sets their size.  Here particles are in classes of size, each with cells of its own (Ogarko and Luding, Computer
// Physics Communications 183, 2012, 931, doi 10.1016/j.cpc.2011.12.019).  A particle looks among those of its class
// and of coarser ones, so that a lump costs its neighbours a look each, and not a look at all who would be near if
// they were lumps.
class PairLists : public LAMMPS_NS::Neighbor {
 public:
  // `class_ratio`: the largest radius of a class over that of the next finer one.
  PairLists(LAMMPS_NS::LAMMPS *lmp, double class_ratio) : Neighbor(lmp), class_ratio_(class_ratio) {}

  // Spheres of one body are no neighbours.
  void know(const FixBodies *bodies) { bodies_ = bodies; }

 private:
  struct SizeClass {
    std::vector<int> numbers, ghost_numbers;
    Cells all, ghosts;
  };

  void choose_build(int index, LAMMPS_NS::NeighRequest *request) override;
  void list_pairs(LAMMPS_NS::NeighList *list);
  void sort_into_classes();
  int find_neighbours(int particle);
  int without_own_body(int particle, int count);
  void recall_histories(LAMMPS_NS::NeighList &list, int particle, int neighbours) const;

  double class_ratio_;
  std::vector<SizeClass> classes_;  // the coarsest first
  std::vector<int> class_of_;
  const FixBodies *bodies_ = nullptr;  // null: particles are single spheres
  std::vector<int> neighbours_;  // of one particle
};

}  // namespace flipflow
