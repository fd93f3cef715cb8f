// Particles whose centre goes through the surface.  A contact pushes a centre back to the side that
// it is on, so that one that is on the other side came there by contacts too soft or steps too long.
// It is looked for in every step, by the way of the centre against the way of the triangles: who
// goes through an opening, past a free edge or between two panels goes through no triangle.

#include "fix_surface.h"

#include <algorithm>

#include "atom.h"
#include "neighbor.h"
#include "update.h"

namespace flipflow {

using namespace LAMMPS_NS;

// No less than the square of how far centre and surface moved against each other in this step; in
// the middle of a step of velocity Verlet its velocity is what it moved by.
double FixSurface::step_length2(int i) const {
  const double surface_m = surface_.farthest_moved_m(update->dt);
  const Vec3 moved_m = update->dt * from(atom->v[i]);
  return 2.0 * (dot(moved_m, moved_m) + surface_m * surface_m);
}

Vec3 FixSurface::place_before(int i) const {
  return from(atom->x[i]) - update->dt * from(atom->v[i]);
}

// A centre that went through a triangle in this step is no farther from it than the step's length;
// so nearly always the distance of the nearest one tells that there is nothing to look for.
void FixSurface::watch_crossing(const ContactSearch::Near &near, double nearest2) {
  const int i = near.sphere;
  const double radius = atom->radius[i], step2 = step_length2(i);
  if (update->setupflag || (step2 < nearest2 && step2 < radius * radius)) return;
  if (search_.crossed(surface_, near, place_before(i), from(atom->x[i]))) add_crossing(i);
}

// Who moves farther against the surface in a step than triangles are listed around it is looked for
// everywhere.  After such a step lists are made anew, so that it is enough to look then.
void FixSurface::watch_long_steps() {
  if (update->setupflag) return;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double listed_m = atom->radius[i] * neighbor->contactDistanceFactor + neighbor->skin;
    if (step_length2(i) < listed_m * listed_m) continue;
    if (search_.crossed_any(surface_, place_before(i), from(atom->x[i]))) add_crossing(i);
  }
}

void FixSurface::add_crossing(int i) {
  const int tag = atom->tag[i];
  const bigint step = update->ntimestep;
  const bool known =
      std::any_of(crossings_.begin(), crossings_.end(),
                  [&](const Crossing &one) { return one.step == step && one.tag == tag; });
  if (!known) crossings_.push_back({tag, step, from(atom->x[i])});
}

}  // namespace flipflow
