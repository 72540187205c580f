!> Hertz contact of two spheres, inclined by the offset of the pair in plan.
!>
!> The overlap W of the spheres is that along the line of their centres, as in the thesis:
!> load = 4/3 E sqrt(R) W**1.5, contact radius = sqrt(R W), maximum pressure = 2 E sqrt(W/R)/pi
!> (Hertz 1882; Johnson, Contact Mechanics, 1985, section 4.2).
module asperity_hertz_law
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response, set_vertical_parts
  use asperity_contact_pairs, only: contact_pair
  use asperity_sphere_overlap, only: stable_overlap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: hertz_law

  !> The law of Hertz.
  type, extends(contact_law) :: hertz_law
    real(real64) :: modulus = 0.0_real64  !! combined modulus, in the unit of the pairs
  contains
    procedure :: respond => respond_elastic
  end type hertz_law

contains

  !> Response of an elastic contact.
  pure subroutine respond_elastic(self, pair, number, penetration, response)
    class(hertz_law), intent(in) :: self            !! law with its modulus
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    integer, intent(in) :: number                   !! place of the pair in its list; not used
    real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response  !! loads, radius, pressure, stiffness
    real(real64) :: root

    if (number < 0 .or. .not. penetration > 0.0_real64) return
    response%overlap = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, penetration)
    response%contact_radius = sqrt(pair%radius * response%overlap)
    root = self%modulus * response%contact_radius
    response%load = root * response%overlap * (4.0_real64 / 3.0_real64)
    response%maximum_pressure = (2.0_real64 / pi) * self%modulus * &
                                sqrt(response%overlap / pair%radius)
    call set_vertical_parts(pair, penetration, 2.0_real64 * root, response)
  end subroutine respond_elastic

end module asperity_hertz_law
