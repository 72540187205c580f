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
    type(decimal_value) :: width(1)
    integer :: side

    associate (deck => spec%deck)
      call fields%require('deck', 'elastic_modulus', 'one')
      call take('elastic_modulus', above_zero, 999999999, 0, deck%elastic_modulus)
      call fields%require('deck', 'poisson_ratio', 'one')
      call take('poisson_ratio', poisson_range, 1, 3, deck%poisson_ratio)
      call fields%require('deck', 'allowed_stress', 'one')
      call take('allowed_stress', not_negative, 999999999, 0, deck%allowed_stress)
      call take('rotation', any_number, 99, 4, deck%rotation)
      width = spec%sides(2)%width
      call take('lower_width', above_zero, 99, 4, width)
      deck%lower_width = width(1)
      call take('x_displacement', any_number, 99, 3, deck%displacement(1:1))
      call take('y_displacement', any_number, 99, 3, deck%displacement(2:2))
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

    !> Takes one number, or one for each side.
    subroutine take(name, range, most, decimals, values)
      character(len=*), intent(in) :: name
      integer, intent(in) :: range, most, decimals
      type(decimal_value), intent(inout) :: values(:)
      integer :: before

      before = fields%problems%count()
      if (size(values) == 2) then
        call fields%take_pair('deck', name, range, values)
      else
        call fields%take_numbers('deck', name, range, values)
      end if
      if (.not. fields%has('deck', name) .or. fields%problems%count() > before) return
      ! Zero where zero is allowed always fits.
      if (.not. all(fits(values, most, decimals) .or. &
                    (range /= above_zero .and. values%digits == 0))) &
        call fields%complain_of('deck', name, 'found a number that its card cannot hold, ' // &
                                'expected fewer digits')
    end subroutine take

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
