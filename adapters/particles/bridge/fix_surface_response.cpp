#include "fix_surface.h"

#include <cmath>

#include "atom.h"

namespace flipflow {

// What a contact does to a surface that moves: `added` is its whole force, of which it gives its
// share, `turned` what it gives besides.  A contact that slides has no tangential spring or damper.
void FixSurface::respond(const Touch &touch,
                         const LIGGGHTS::ContactModels::SurfacesIntersectData &contact,
                         const double *history, Vec3 added, Vec3 turned) {
  const Vec3 n = from(contact.en), slip = {contact.vtr1, contact.vtr2, contact.vtr3};
  const double neck = laws_.neck_m(atom->radius[contact.i], contact.deltan, history);
  Vec3 damping = -contact.gamman * contact.vn * n;
  double spring = 0.0, damper = 0.0;
  if (laws_.tangential_spring) {
    const Vec3 stretch = from(history + laws_.spring());
    const Vec3 across = added - dot(added, n) * n + contact.kt * stretch;  // -damper slip, or zero
    const double sticking = contact.gammat * norm(slip);
    if (norm(across) >= 0.5 * sticking) {
      spring = contact.kt;
      damper = contact.gammat;
      damping = damping - damper * slip;
    }
  }
  const double w = touch.weight, normal = 2.0 * law(contact.i, touch).e_star_Pa * neck;
  const double *corner = touch.at.weight;
  response_.add({contact.i,
                 search_.triangle(touch.triangle),
                 {corner[0], corner[1], corner[2]},
                 n,
                 w * added,
                 w * (added - damping) + turned,
                 {w * normal, w * spring},
                 {w * contact.gamman, w * damper},
                 contact.cri});
}

}  // namespace flipflow
