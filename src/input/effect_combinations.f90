!> Which effects go together, and why others do not.
module asperity_effect_combinations
  implicit none
  private

  public :: why_not_together

  ! Two effects that are not computed together.
  type :: refused_pair
    character(len=11) :: one, other  ! as in &effects
    character(len=72) :: why
    character(len=8) :: way = ''     ! only where `one` is simulated in this way; blank: in any
  end type refused_pair

  type(refused_pair), parameter :: refused(*) = [ &
    refused_pair('adhesion', 'plasticity', 'the theories of adhesion are elastic'), &
    refused_pair('adhesion', 'creep', 'the theory of creep knows no attraction'), &
    refused_pair('adhesion', 'interaction', &
                 'neighbours are lowered by pressures of Hertz, not by those of adhesion'), &
    refused_pair('adhesion', 'friction', &
                 'shear changes adhesion, and Coulomb''s law knows no attraction'), &
    refused_pair('creep', 'plasticity', 'creep here is that of an elastic contact'), &
    refused_pair('creep', 'friction', 'slip and creep together have no closed theory'), &
    refused_pair('interaction', 'plasticity', &
                 'cells are elastic: plasticity goes with interaction = ''coupled''', 'boundary')]

contains

  !> Why two effects are not computed together; empty when they are.
  pure function why_not_together(first, first_way, second, second_way) result(why)
    character(len=*), intent(in) :: first       !! an effect, as in &effects
    character(len=*), intent(in) :: first_way   !! how it is simulated
    character(len=*), intent(in) :: second      !! another one
    character(len=*), intent(in) :: second_way  !! how it is simulated
    character(len=:), allocatable :: why
    integer :: i

    why = ''
    do i = 1, size(refused)
      if (meets(refused(i), first, first_way, second) .or. &
          meets(refused(i), second, second_way, first)) &
        why = first // ' and ' // second // ' do not go together: ' // trim(refused(i)%why)
    end do
  end function why_not_together

  ! Whether a refusal is of these two.
  pure logical function meets(refusal, one, way, other)
    type(refused_pair), intent(in) :: refusal
    character(len=*), intent(in) :: one, way, other

    meets = refusal%one == one .and. refusal%other == other .and. &
            (refusal%way == '' .or. refusal%way == way)
  end function meets

end module asperity_effect_combinations
