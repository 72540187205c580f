!> Values that a card deck brings into a scene, from inches and psi to cm and N.
module asperity_scene_deck
  use asperity_card_deck, only: card_deck, model_cards, parse_card_deck
  use asperity_card_reader, only: deck_fields, modulus_field, radius_field, shift_field, &
                                  width_field, x_field, y_field, z_field
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_input_text, only: read_text
  use asperity_kept_records, only: checksum
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: is_a_double
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_values, only: scene, scene_motion, scene_surface, thesis_limit_load, &
                                   thesis_positions
  implicit none
  private

  public :: surfaces_from_deck

  ! 2.54 cm in an inch, 0.6894 N/cm2 in a psi, as in the thesis.
  type(decimal_value), parameter :: inch = decimal_value(254_int64, -2)
  type(decimal_value), parameter :: psi = decimal_value(6894_int64, -4)

  ! Slopes of the support plates along x and y.
  real(real64), parameter :: upper_slope(2) = [0.00400_real64, -0.00058_real64]
  real(real64), parameter :: lower_slope(2) = [-0.00067_real64, -0.00045_real64]

  ! Distance of the positions of the thesis' sweep along x, cm.
  type(decimal_value), parameter :: thesis_step = decimal_value(1_int64, -1)

  integer, parameter :: header_cards = 4  ! cards before the first asperity

contains

  !> Fills a scene from a deck: surfaces, material, angles, slopes, gap and limit load, all in
  !> cm and N. `sweep` is the motion that the bare deck stands for.
  subroutine surfaces_from_deck(path, target_scene, sweep, problems, text)
    character(len=*), intent(in) :: path           !! path of the deck
    type(scene), intent(inout) :: target_scene     !! the scene to fill
    type(scene_motion), intent(out) :: sweep       !! the thesis' sweep, XDISPL and YDISPL added
    type(problem_list), intent(inout) :: problems  !! all that is wrong with the deck
    character(len=*), intent(in), optional :: text !! the deck, when it has been read already
    type(card_deck) :: deck
    type(problem_list) :: found
    type(decimal_value) :: shift
    character(len=:), allocatable :: own_text

    if (present(text)) then
      call parse_card_deck(path, text, deck, found)
    else
      call read_text(path, 'a card deck', own_text, found)
      if (found%count() == 0) call parse_card_deck(path, own_text, deck, found)
      target_scene%upper%checksum = checksum(own_text)
      target_scene%lower%checksum = target_scene%upper%checksum
    end if
    call found%append(deck%unchecked)
    if (found%count() == 0) then
      target_scene%from_deck = .true.
      target_scene%deck = deck
      target_scene%notes = deck%notes
      target_scene%lower_is_mirrored = .true.
      target_scene%units = [character(len=16) :: 'cm', 'N']
      target_scene%limit%value = thesis_limit_load
      target_scene%limit%from_thesis = .true.
      call convert_model(path, 2, header_cards, deck%upper, target_scene%upper, found)
      call convert_model(path, 3, header_cards + deck%upper%number, deck%lower, &
                         target_scene%lower, found)
      target_scene%upper%slope = upper_slope
      target_scene%lower%slope = lower_slope
      call convert_number(3, width_field, deck%lower_width, inch, shift, found)
      target_scene%lower_mirror_width = decimal_to_real64(shift)
      ! XDISPL and YDISPL are added, as the original's print says.
      call convert_number(header_cards, shift_field(1), deck%x_displacement, inch, shift, found)
      sweep%x_first = decimal_to_real64(thesis_step) + decimal_to_real64(shift)
      if (shift%power_of_ten >= -17 .and. shift%power_of_ten <= -1) &
        sweep%x_first = decimal_to_real64(decimal_value( &
          10_int64**(-1 - shift%power_of_ten) + shift%all_digits, shift%power_of_ten))
      sweep%x_step = decimal_to_real64(thesis_step)
      call convert_number(header_cards, shift_field(2), deck%y_displacement, inch, shift, found)
      sweep%y_first = decimal_to_real64(shift)
      sweep%positions = thesis_positions
    end if
    call problems%append(found)
  end subroutine surfaces_from_deck

  !> One model in cm and N/cm2. Card `header` holds its numbers; its asperities follow `before`.
  subroutine convert_model(path, header, before, model, surface, problems)
    character(len=*), intent(in) :: path
    integer, intent(in) :: header, before
    type(model_cards), intent(in) :: model
    type(scene_surface), intent(inout) :: surface
    type(problem_list), intent(inout) :: problems
    type(decimal_value) :: modulus, radius
    type(decimal_value), dimension(model%number) :: x, y, z
    integer :: i

    surface%file = path
    call convert_number(header, radius_field, model%radius, inch, radius, problems)
    call convert_number(header, modulus_field, model%elastic_modulus, psi, modulus, problems)
    surface%elastic_modulus = decimal_to_real64(modulus)
    surface%poisson_ratio = decimal_to_real64(model%poisson_ratio)
    surface%rotation = decimal_to_real64(model%angle)
    do i = 1, model%number
      call convert_number(before + i, x_field, model%x(i), inch, x(i), problems)
      call convert_number(before + i, y_field, model%y(i), inch, y(i), problems)
      call convert_number(before + i, z_field, model%z(i), inch, z(i), problems)
    end do
    surface%x = decimal_to_real64(x)
    surface%y = decimal_to_real64(y)
    surface%height = decimal_to_real64(z)
    surface%radius = spread(decimal_to_real64(radius), 1, model%number)
  end subroutine convert_model

  !> Multiplies by a unit, exactly. A card's field has at most 10 digits, so nothing overflows.
  subroutine convert_number(line, field, value, unit, converted, problems)
    integer, intent(in) :: line, field
    type(decimal_value), intent(in) :: value, unit
    type(decimal_value), intent(out) :: converted
    type(problem_list), intent(inout) :: problems

    converted = decimal_value(value%all_digits * unit%all_digits, value%power_of_ten + &
      unit%power_of_ten)
    if (is_a_double(converted)) return
    call problems%add_at(line, deck_fields(field)%first, 'a number beyond the range of a ' // &
                         'double when converted: found exponent ' // &
                         decimal_text(value%power_of_ten) // ', expected a number of ordinary size')
    converted = decimal_value()
  end subroutine convert_number

end module asperity_scene_deck
