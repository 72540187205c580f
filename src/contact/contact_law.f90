!> The interface of all contact laws: the response of a single contact to a penetration.
!>
!> Interaction, friction and load control evaluate a law of any type. A law with a history (plastic
!> flow, adhesion) keeps it by the number of the contact.
module asperity_contact_law
  use asperity_contact_pairs, only: contact_pair
  use asperity_kinds, only: real64
  implicit none
  private

  public :: contact_law, contact_response, set_vertical_parts

  !> Response of one contact. Zeros where it does not touch.
  type :: contact_response
    real(real64) :: overlap = 0.0_real64         !! decrease of the distance of the centres
    real(real64) :: contact_radius = 0.0_real64  !! radius of the contact circle
    real(real64) :: load = 0.0_real64            !! force normal to the contact
    real(real64) :: cosine = 1.0_real64          !! cosine of the inclination
    real(real64) :: vertical_load = 0.0_real64   !! load times cosine
    real(real64) :: stiffness = 0.0_real64       !! d vertical_load / d penetration
    real(real64) :: maximum_pressure = 0.0_real64
  end type contact_response

  !> A law of contact.
  type, abstract :: contact_law
  contains
    procedure(respond_to), deferred :: respond  !! response to a penetration
  end type contact_law

  abstract interface
    !> Computes the response to a penetration, in the units of the pair. Continuous in it.
    pure subroutine respond_to(self, pair, number, penetration, response)
      import :: contact_law, contact_pair, contact_response, real64
      implicit none
      class(contact_law), intent(in) :: self          !! law with its history
      type(contact_pair), intent(in) :: pair          !! geometry of the contact
      integer, intent(in) :: number                   !! place of the pair in its list
      real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
      type(contact_response), intent(out) :: response  !! loads, radius, pressure, stiffness
    end subroutine respond_to
  end interface

contains

  !> Sets vertical load and stiffness from the load and its slope along the line of centres, with
  !> dW/dp = cosine and d(cosine)/dp = -sine**2 over the distance of the centres.
  pure subroutine set_vertical_parts(pair, penetration, slope, response)
    type(contact_pair), intent(in) :: pair             !! geometry of the contact
    real(real64), intent(in) :: penetration            !! vertical, past first touch
    real(real64), intent(in) :: slope                  !! d load/d overlap
    type(contact_response), intent(inout) :: response  !! with its load and overlap
    real(real64) :: centres

    centres = pair%s - response%overlap
    response%cosine = (pair%zc - penetration) / centres
    response%vertical_load = response%load * response%cosine
    response%stiffness = slope * response%cosine**2 - &
                         response%load * (pair%d / centres)**2 / centres
  end subroutine set_vertical_parts

end module asperity_contact_law
