!> What a card deck of generated surfaces can hold.
module asperity_generation_checks
  use asperity_decimal, only: decimal_value
  use asperity_generation_values, only: exact_value, generation_spec, side_names
  use asperity_kinds, only: real128
  use asperity_number_ranges, only: above_zero, any_number, not_negative, poisson_range
  use asperity_problems, only: decimal_text
  use asperity_scene_fields, only: scene_fields
  implicit none
  private

  public :: check_deck

  ! Most asperities of a model: five columns.
  integer, parameter :: most_cards = 99999

contains

  !> Takes group &deck and checks that all numbers fit onto their cards.
  subroutine check_deck(fields, good_plane, good_heights, good_radii, spec)
    type(scene_fields), intent(inout) :: fields   !! the text; problems are added
    logical, intent(in) :: good_plane             !! number, length and width are known
    logical, intent(in) :: good_heights           !! heights are known
    logical, intent(in) :: good_radii             !! radii are known
    type(generation_spec), intent(inout) :: spec  !! its deck is filled
    integer :: side

    associate (deck => spec%deck)
      call take('elastic_modulus', above_zero, .true., 999999999, 0, deck%elastic_modulus)
      call take('poisson_ratio', poisson_range, .true., 1, 3, deck%poisson_ratio)
      call take('allowed_stress', not_negative, .true., 999999999, 0, deck%allowed_stress)
      call take('rotation', any_number, .false., 99, 4, deck%rotation)
      deck%lower_width = spec%sides(2)%width
      call take_one('lower_width', above_zero, 99, 4, deck%lower_width)
      call take_one('x_displacement', any_number, 99, 3, deck%displacement(1))
      call take_one('y_displacement', any_number, 99, 3, deck%displacement(2))
    end associate
    do side = 1, 2
      associate (wanted => spec%sides(side))
        if (good_plane) then
          call need(wanted%number <= most_cards, 'at most ' // decimal_text(most_cards) // &
                    ' asperities')
          call need(fits(wanted%length, 99, 3) .and. fits(wanted%width, 99, 3), &
                    'a length and a width from 0.001 to 99 in')
        end if
        if (good_radii) &
          call need(wanted%radius%highest <= wanted%radius%lowest .and. &
                    fits(wanted%radius%mean, 9, 3), 'one radius for all, from 0.001 to 9 in')
        if (good_heights) &
          call need(abs(wanted%height%lowest) < 9.0_real128 .and. &
                    abs(wanted%height%highest) < 9.0_real128, 'heights between -9 and 9 in')
      end associate
    end do

  contains

    subroutine take(name, range, is_needed, most, decimals, values)
      character(len=*), intent(in) :: name
      integer, intent(in) :: range, most, decimals
      logical, intent(in) :: is_needed
      type(decimal_value), intent(inout) :: values(2)
      integer :: before

      before = fields%problems%count()
      call fields%take_pair('deck', name, range, values)
      if (is_needed .and. .not. fields%has('deck', name)) then
        call fields%complain_of_group('deck', 'no ' // name // ' in &deck, expected one')
      else if (fields%has('deck', name) .and. fields%problems%count() == before) then
        ! Zero where zero is allowed always fits.
        if (.not. all(fits(values, most, decimals) .or. &
                      (range /= above_zero .and. values%digits == 0))) call refuse(name)
      end if
    end subroutine take

    subroutine take_one(name, range, most, decimals, value)
      character(len=*), intent(in) :: name
      integer, intent(in) :: range, most, decimals
      type(decimal_value), intent(inout) :: value
      integer :: before

      before = fields%problems%count()
      call fields%take_number('deck', name, range, value)
      if (.not. fields%has('deck', name) .or. fields%problems%count() > before) return
      if (.not. (fits(value, most, decimals) .or. &
                 (range /= above_zero .and. value%digits == 0))) call refuse(name)
    end subroutine take_one

    subroutine refuse(name)
      character(len=*), intent(in) :: name

      call fields%complain_of('deck', name, 'found a number that its card cannot hold, ' // &
                              'expected fewer digits')
    end subroutine refuse

    subroutine need(is_so, expected)
      logical, intent(in) :: is_so
      character(len=*), intent(in) :: expected

      if (.not. is_so) &
        call fields%complain_of_group('deck', 'the ' // trim(side_names(side)) // ' surface ' // &
             'does not fit onto cards, expected ' // expected)
    end subroutine need

  end subroutine check_deck

  !> Whether a number is at most so large, and not lost behind the last decimal of its card.
  elemental logical function fits(value, most, decimals)
    type(decimal_value), intent(in) :: value
    integer, intent(in) :: most, decimals
    real(real128) :: size_of

    size_of = abs(exact_value(value))
    fits = size_of <= real(most, real128) .and. 2 * size_of * 10.0_real128**decimals >= 1.0_real128
  end function fits

end module asperity_generation_checks
