!> What a single contact answers to a penetration: the one interface of all laws.
!>
!> Interaction, friction and load control ask a law and do not know which one it is. A law that
!> remembers (plastic flow, creep) keeps what it needs by the number of the contact.
module asperity_contact_law
  use asperity_contact_pairs, only: contact_pair
  use asperity_kinds, only: real64
  implicit none
  private

  public :: contact_law, contact_response

  !> The answer of one contact. Zeros where it does not touch.
  type :: contact_response
    real(real64) :: overlap = 0.0_real64         !! decrease of the distance of the centres
    real(real64) :: contact_radius = 0.0_real64  !! of the contact circle
    real(real64) :: load = 0.0_real64            !! force normal to the contact
    real(real64) :: cosine = 1.0_real64          !! of the contact's inclination
    real(real64) :: vertical_load = 0.0_real64   !! load times cosine
    real(real64) :: stiffness = 0.0_real64       !! d vertical_load / d penetration
    real(real64) :: maximum_pressure = 0.0_real64
  end type contact_response

  !> A law of contact.
  type, abstract :: contact_law
  contains
    procedure(respond_to), deferred :: respond  !! the answer to a penetration
  end type contact_law

  abstract interface
    !> The answer of a contact to a penetration, in the units of its pair. Continuous in it.
    pure subroutine respond_to(self, pair, number, penetration, response)
      import :: contact_law, contact_pair, contact_response, real64
      implicit none
      class(contact_law), intent(in) :: self          !! the law
      type(contact_pair), intent(in) :: pair          !! who touches
      integer, intent(in) :: number                   !! place of the pair in its list
      real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
      type(contact_response), intent(out) :: response !! the answer
    end subroutine respond_to
  end interface

end module asperity_contact_law
