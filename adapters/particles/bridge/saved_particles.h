#pragma once

#include "saved_state.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

// This rank's particles, their neighbour lists and the contact history in them.
//
// Forces are summed up in the order of the particles in memory and of the pairs in the lists, so
// both must come back in their order.  The lists themselves are not saved: LIGGGHTS makes the same
// ones again at the places that it made them at, which it keeps to see who has moved far since.
void save_particles(LAMMPS_NS::LAMMPS &lmp, SavedState &saved);

// Where this rank's particles were when their neighbours were last listed, (particles, 3).
double **listed_at(LAMMPS_NS::LAMMPS &lmp);

// Has nothing been listed anew, on any rank, since the state was saved, or been listed alike?
// Then going back is a matter of copying numbers, a tenth of listing.
bool is_listed_as_saved(LAMMPS_NS::LAMMPS &lmp, const SavedState &saved);

// Else in two parts, between which LIGGGHTS lists neighbours: first the saved particles take the place of
// all others, where they were last listed; then they go to where they were saved.
void place_as_listed(LAMMPS_NS::LAMMPS &lmp, const SavedState &saved);
void go_on_as_saved(LAMMPS_NS::LAMMPS &lmp, const SavedState &saved);

// A solid sphere at rest at the end of this rank's particles; returns its place there.
int add_particle(LAMMPS_NS::LAMMPS &lmp, int id, int type, const double *position_m,
                 double radius_m, double density_kg_per_m3);

}  // namespace flipflow
