!> The law of adhering contacts, inclined by the offset of the pair in plan.
!>
!> Load and contact radius are functions of the overlap of the spheres along the line of their
!> centres, as in Hertz' law; a negative overlap is a gap. Over a range of gaps a contact adheres
!> only if it adhered before: the law has a hysteresis and keeps which contacts adhered.
module asperity_adhesion_law
  use asperity_adhesion_contact, only: adhering_contact, adheres_at, adhesion_numbers, &
                                       answer_along_centres, central_answer, model_hertz, &
                                       new_adhering_contact
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_hertz_law, only: hertz_law
  use asperity_sphere_overlap, only: stable_overlap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: adhesion_law, new_adhesion_law

  !> The law with the parameters and the state of each contact.
  type, extends(contact_law) :: adhesion_law
    type(adhesion_numbers) :: numbers                 !! in the units of the pairs
    type(adhering_contact), allocatable :: known(:)   !! by the number of the contact
    logical, allocatable :: adhered(:)                !! by the number: at the last state
  contains
    procedure :: respond => respond_adhering
    procedure :: is_adhering
    procedure :: least_load
  end type adhesion_law

contains

  !> Makes the law of a position without adhering contacts.
  subroutine new_adhesion_law(numbers, pairs, law)
    type(adhesion_numbers), intent(in) :: numbers  !! in the units of the pairs
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(adhesion_law), intent(out) :: law         !! law of the position
    integer :: i
    logical :: same

    law%numbers = numbers
    allocate (law%known(size(pairs%list)), law%adhered(size(pairs%list)))
    law%adhered = .false.
    do i = 1, size(pairs%list)
      ! Many scenes have one radius: its curve is computed once.
      same = .false.
      if (i > 1) same = .not. abs(pairs%list(i)%radius - law%known(i - 1)%radius) > 0.0_real64
      if (same) then
        law%known(i) = law%known(i - 1)
      else
        call new_adhering_contact(numbers, pairs%list(i)%radius, law%known(i))
      end if
    end do
  end subroutine new_adhesion_law

  !> Response of a contact. Continuous in the penetration except where the contact snaps. The
  !> pressure is that at the centre of the contact circle, the largest.
  pure subroutine respond_adhering(self, pair, number, penetration, response)
    class(adhesion_law), intent(in) :: self         !! law with its history
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    integer, intent(in) :: number                   !! place of the pair in its list
    real(real64), intent(in) :: penetration         !! vertical, less than zc; negative: a gap
    type(contact_response), intent(out) :: response !! loads, radius, pressure, stiffness
    type(hertz_law) :: hertz
    type(central_answer) :: answer
    real(real64) :: centres, overlap

    associate (contact => self%known(number))
      if (contact%model == model_hertz) then
        hertz%modulus = self%numbers%modulus
        call hertz%respond(pair, number, penetration, response)
        return
      end if
      overlap = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, penetration)
      if (.not. adheres_at(contact, overlap, self%adhered(number))) return
      call answer_along_centres(self%numbers, contact, overlap, answer)
    end associate
    centres = pair%s - overlap
    response%overlap = overlap
    response%contact_radius = answer%contact_radius
    response%load = answer%load
    response%cosine = (pair%zc - penetration) / centres
    response%vertical_load = response%load * response%cosine
    response%stiffness = answer%stiffness * response%cosine**2 - &
                         response%load * (pair%d / centres)**2 / centres
    response%maximum_pressure = answer%pressure
  end subroutine respond_adhering

  !> Whether a contact adheres at a penetration.
  pure logical function is_adhering(self, pair, number, penetration)
    class(adhesion_law), intent(in) :: self  !! law with its history
    type(contact_pair), intent(in) :: pair   !! geometry of the contact
    integer, intent(in) :: number            !! place of the pair in its list
    real(real64), intent(in) :: penetration  !! vertical, less than zc; negative: a gap

    is_adhering = adheres_at(self%known(number), stable_overlap(pair%s, pair%d, pair%zc, &
                             pair%rest, penetration), self%adhered(number))
  end function is_adhering

  !> Lower bound of the load of a contact that unloads between two penetrations. The load along the
  !> line of centres is a convex function of the overlap: its least value is at the lower end where
  !> the stiffness is positive there, at the upper end where it is negative there, else the pull-off
  !> force.
  pure real(real64) function least_load(self, pair, number, low, high, vertical) result(load)
    class(adhesion_law), intent(in) :: self  !! law with its history
    type(contact_pair), intent(in) :: pair   !! geometry of the contact
    integer, intent(in) :: number            !! place of the pair in its list
    real(real64), intent(in) :: low, high    !! penetrations, low <= high < zc
    logical, intent(in) :: vertical          !! whether the vertical part of the load is meant
    type(central_answer) :: lower, upper
    real(real64) :: cosines(2), overlaps(2), part

    load = 0.0_real64
    associate (contact => self%known(number))
      overlaps = [stable_overlap(pair%s, pair%d, pair%zc, pair%rest, low), &
                  stable_overlap(pair%s, pair%d, pair%zc, pair%rest, high)]
      cosines = (pair%zc - [low, high]) / (pair%s - overlaps)
      part = merge(contact%snap_off, contact%snap_in, self%adhered(number))
      if (overlaps(2) < part) return
      call answer_along_centres(self%numbers, contact, max(overlaps(1), part), lower)
      load = lower%load
      if (lower%stiffness < 0.0_real64) then
        call answer_along_centres(self%numbers, contact, overlaps(2), upper)
        load = merge(-contact%pull_off, upper%load, upper%stiffness > 0.0_real64)
      end if
      if (overlaps(1) < part) load = min(load, 0.0_real64)
    end associate
    if (vertical) load = min(load * cosines(1), load * cosines(2))
  end function least_load

end module asperity_adhesion_law
