!> A generated surface as CSV, and two of them as a card deck of the original program.
!>
!> Every number is written exactly: all its digits, and no more. A deck is in inches, psi and
!> radians; its asperities were drawn in whole thousandths (positions) and ten thousandths (heights)
!> of an inch, which its cards hold exactly. Other numbers are rounded to their fields, with a note.
module asperity_surface_text
  use asperity_card_reader, only: angle_field, count_field, deck_fields, height_max_field, &
                                  modulus_field, radius_field, ratio_field, shift_field, &
                                  stress_field, width_field, x_field, y_field, z_field
  use asperity_generated_surface, only: generated_surface
  use asperity_generation_values, only: exact_value, generation_spec
  use asperity_kinds, only: int64, real128, real64
  use asperity_problems, only: problem_list
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: surface_as_csv, surfaces_as_deck, write_decimal, field_length

  character(len=*), parameter :: header = 'x,y,height,radius' // achar(10)
  ! More digits than this behind the point are written with an exponent.
  integer, parameter :: most_decimals = 17

  !> Characters of a field: the longest number and its exponent have room.
  integer, parameter :: field_length = 32

contains

  !> A surface as CSV: a header, then one line an asperity.
  subroutine surface_as_csv(surface, text, used)
    type(generated_surface), intent(in) :: surface      !! surface in whole units
    character(len=:), allocatable, intent(out) :: text  !! the whole file, and some room behind it
    integer(int64), intent(out) :: used                 !! bytes of the file
    integer :: i, longest

    longest = 4 + longest_of(surface%x, surface%position_decimals) + &
              longest_of(surface%y, surface%position_decimals) + &
              longest_of(surface%height, surface%height_decimals) + &
              longest_of(surface%radius, surface%radius_decimals)
    allocate (character(len=len(header) + size(surface%x, kind=int64) * longest) :: text)
    text(:len(header)) = header
    used = len(header, int64)
    do i = 1, size(surface%x)
      call put_number(surface%x(i), surface%position_decimals, ',')
      call put_number(surface%y(i), surface%position_decimals, ',')
      call put_number(surface%height(i), surface%height_decimals, ',')
      call put_number(surface%radius(min(i, size(surface%radius))), surface%radius_decimals, &
                      achar(10))
    end do

  contains

    subroutine put_number(value, decimals, separator)
      integer(int64), intent(in) :: value
      integer, intent(in) :: decimals
      character(len=1), intent(in) :: separator
      character(len=field_length) :: field
      integer(int64) :: last
      integer :: first

      call write_decimal(value, decimals, field, first)
      last = used + int(field_length - first + 1, int64)
      text(used + 1_int64:last) = field(first:)
      used = last + 1_int64
      text(used:used) = separator
    end subroutine put_number

    !> Characters that the longest number of a column may take.
    pure integer function longest_of(values, decimals)
      integer(int64), intent(in) :: values(:)
      integer, intent(in) :: decimals
      character(len=field_length) :: field
      integer :: first

      ! One more character is for the sign of a smaller number.
      call write_decimal(max(maxval(values), -minval(values)), decimals, field, first)
      longest_of = field_length - first + 2
    end function longest_of

  end subroutine surface_as_csv

  !> Writes `value * 10**(-decimals)`, as `-0.0123`, `12` or `5E3`, at the right of a field.
  pure subroutine write_decimal(value, decimals, field, first)
    integer(int64), intent(in) :: value                  !! units, less than 10**18 in size
    integer, intent(in) :: decimals                      !! a unit is 10**(-decimals)
    character(len=field_length), intent(inout) :: field  !! number at its right end, the rest
                                                         !! unchanged
    integer, intent(out) :: first  !! first position of the number
    character(len=12) :: power
    integer(int64) :: rest, above
    integer :: at, behind

    at = field_length
    behind = decimals
    if (decimals > most_decimals .or. decimals < 0) then
      write (power, '(i0)') -decimals
      at = at - len_trim(power)
      field(at + 1:) = power
      field(at:at) = 'E'
      at = at - 1
      behind = 0
    end if
    rest = abs(value)
    do
      above = rest / 10_int64
      field(at:at) = achar(iachar('0') + int(rest - 10_int64 * above))
      rest = above
      at = at - 1
      behind = behind - 1
      if (behind == 0) then
        field(at:at) = '.'
        at = at - 1
      end if
      ! One digit stands before the point.
      if (rest == 0_int64 .and. behind < 0) exit
    end do
    first = at + 1
    if (value < 0_int64) then
      first = at
      field(at:at) = '-'
    end if
  end subroutine write_decimal

  !> Writes two surfaces as the cards of a deck. `notes` reports the values that are rounded on
  !> them.
  subroutine surfaces_as_deck(spec, upper, lower, text, notes)
    type(generation_spec), intent(in) :: spec           !! values of the cards beside the asperities
    type(generated_surface), intent(in) :: upper        !! upper surface in card units
    type(generated_surface), intent(in) :: lower        !! lower surface in card units
    character(len=:), allocatable, intent(out) :: text  !! the whole deck
    type(problem_list), intent(inout) :: notes          !! one note for each rounded value
    type(text_buffer) :: cards

    call cards%append('NO  YES' // achar(10))
    call cards%append(model_card(1, upper) // achar(10))
    call cards%append(model_card(2, lower) // &
                      real_card(spec%deck%lower_width, width_field, 'lower_width') // achar(10))
    call cards%append(real_card(spec%deck%rotation(1), angle_field(1), 'rotation') // &
                      real_card(spec%deck%rotation(2), angle_field(2), 'rotation') // &
                      real_card(spec%deck%displacement(1), shift_field(1), 'x_displacement') // &
                      real_card(spec%deck%displacement(2), shift_field(2), 'y_displacement') // &
                      achar(10))
    call add_asperities(upper, cards)
    call add_asperities(lower, cards)
    text = cards%text()

  contains

    !> Columns 1 to 40 of a model's card.
    function model_card(side, surface) result(columns)
      integer, intent(in) :: side
      type(generated_surface), intent(in) :: surface
      character(len=:), allocatable :: columns
      integer(int64) :: highest

      ! The greatest height, to the next thousandth above; a sphere is no higher than its diameter.
      highest = min((max(0_int64, maxval(surface%height)) + 9_int64) / 10_int64, &
                    2_int64 * surface%radius(1) - 1_int64)
      columns = text_of_field(int(size(surface%x), int64), count_field) // &
                real_card(spec%sides(side)%radius%mean, radius_field, 'the radius') // &
                text_of_field(highest, height_max_field) // &
                real_card(spec%deck%elastic_modulus(side), modulus_field, 'elastic_modulus') // &
                real_card(spec%deck%poisson_ratio(side), ratio_field, 'poisson_ratio') // &
                real_card(spec%deck%allowed_stress(side), stress_field, 'allowed_stress')
    end function model_card

    !> A number on a card, rounded to its decimals.
    function real_card(value, field, name) result(columns)
      real(real64), intent(in) :: value
      integer, intent(in) :: field
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: columns
      real(real128) :: exact
      integer(int64) :: units

      exact = exact_value(value) * 10.0_real128**deck_fields(field)%decimals
      units = nint(exact, int64)
      columns = text_of_field(units, field)
      if (abs(exact - real(units, real128)) > 1.0e-15_real128) &
        call notes%add('note: ' // name // ' is rounded to ' // trim(adjustl(columns)) // &
                       ', as a card holds it')
    end function real_card

  end subroutine surfaces_as_deck

  !> Appends the cards of one surface's asperities.
  subroutine add_asperities(surface, cards)
    type(generated_surface), intent(in) :: surface
    type(text_buffer), intent(inout) :: cards
    integer :: i

    do i = 1, size(surface%x)
      call cards%append(text_of_field(surface%x(i), x_field) // &
                        text_of_field(surface%y(i), y_field) // &
                        text_of_field(surface%height(i), z_field) // achar(10))
    end do
  end subroutine add_asperities

  !> A number of units in the columns of a card. Without decimals a point ends a real number, but
  !> not the count of asperities, which has 5 columns.
  pure function text_of_field(units, field) result(columns)
    integer(int64), intent(in) :: units
    integer, intent(in) :: field
    character(len=deck_fields(field)%last - deck_fields(field)%first + 1) :: columns
    character(len=field_length) :: text
    integer :: first

    text = ''
    call write_decimal(units, deck_fields(field)%decimals, text, first)
    if (deck_fields(field)%decimals == 0 .and. len(columns) > 5) text = text(2:) // '.'
    ! A sign that has no column takes that of the zero before the point.
    if (field_length - first + 1 > len(columns) .and. index(text(first:), '-0.') == 1) &
      text(first + 1:first + 1) = '-'
    columns = text(field_length - len(columns) + 1:)
  end function text_of_field

end module asperity_surface_text
