!> Names of the units of a run, where its scene or deck gives them. No value is converted.
module asperity_unit_names
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: has_units, length_power, powers_of, unit_powers, units_in_words, unit_of, &
            with_unit
  public :: is_number, is_length, is_force, is_area, is_pressure, is_moment

  !> Powers of length, force and time in the unit of a quantity, or the unit itself where it is made
  !> of others, as `S` for siemens.
  type :: unit_powers
    integer :: length = 0            !! power of the length
    integer :: force = 0             !! power of the force
    integer :: time = 0              !! power of the time, whose unit has no name in a scene
    character(len=8) :: word = ''    !! the unit; blank: of the powers
  end type unit_powers

  type(unit_powers), parameter :: is_number = unit_powers()          !! a plain number
  type(unit_powers), parameter :: is_length = unit_powers(length=1)  !! a length
  type(unit_powers), parameter :: is_force = unit_powers(force=1)    !! a force
  type(unit_powers), parameter :: is_area = unit_powers(length=2)    !! an area
  type(unit_powers), parameter :: is_pressure = unit_powers(length=-2, force=1)  !! a pressure
  type(unit_powers), parameter :: is_moment = unit_powers(length=1, force=1)  !! moment, or energy

contains

  !> Whether the units have names.
  pure logical function has_units(scene_in)
    type(scene), intent(in) :: scene_in  !! what was solved

    has_units = scene_in%units(1) /= ''
  end function has_units

  !> `length mm, force N, area mm2, pressure N/mm2`.
  pure function units_in_words(scene_in) result(text)
    type(scene), intent(in) :: scene_in    !! scene with unit names
    character(len=:), allocatable :: text  !! one line

    text = 'length ' // unit_of(scene_in, is_length) // ', force ' // &
           unit_of(scene_in, is_force) // ', area ' // unit_of(scene_in, is_area) // &
           ', pressure ' // unit_of(scene_in, is_pressure)
  end function units_in_words

  !> The unit of a quantity that holds the modulus and the length to some powers.
  pure type(unit_powers) function powers_of(powers)
    integer, intent(in) :: powers(2)  !! of the modulus, of the length

    powers_of = unit_powers(length=powers(2) - 2 * powers(1), force=powers(1))
  end function powers_of

  !> Unit of a quantity in the units of the scene; empty where it has none.
  pure function unit_of(scene_in, powers) result(unit)
    type(scene), intent(in) :: scene_in      !! with or without units
    type(unit_powers), intent(in) :: powers  !! of the quantity
    character(len=:), allocatable :: unit    !! for instance `mm2`, `MPa`, `N/cm2`
    ! Length, force, and the name of a force on their area.
    character(len=*), parameter :: named(3, 5) = reshape([character(len=3) :: &
      'mm', 'N', 'MPa', 'um', 'uN', 'MPa', 'm', 'N', 'Pa', 'um', 'mN', 'GPa', 'nm', 'nN', 'GPa'], &
      [3, 5])
    integer :: known

    unit = composed_unit(length_unit(scene_in), trim(scene_in%units(2)), powers)
    if (powers%length /= is_pressure%length .or. powers%force /= is_pressure%force) return
    known = findloc(named(1, :) == length_unit(scene_in) .and. named(2, :) == scene_in%units(2), &
                    .true., 1)
    if (known > 0) unit = trim(named(3, known))
  end function unit_of

  ! A unit of names of length and force: `N/mm2`, `N mm`; empty where a name is.
  pure function composed_unit(length, force, powers) result(unit)
    character(len=*), intent(in) :: length, force
    type(unit_powers), intent(in) :: powers
    character(len=:), allocatable :: unit, below

    unit = trim(powers%word)
    if (unit /= '' .or. powers%time /= 0 .or. all([powers%length, powers%force] == 0) .or. &
        (powers%length /= 0 .and. length == '') .or. (powers%force /= 0 .and. force == '')) return
    unit = trim(adjustl(power_text(force, powers%force) // ' ' // &
                        power_text(length, powers%length)))
    below = trim(adjustl(power_text(force, -powers%force) // ' ' // &
                         power_text(length, -powers%length)))
    if (below /= '' .and. unit == '') unit = '1'
    if (below /= '') unit = unit // '/' // below
  end function composed_unit

  ! A name to a power; empty for one that is not positive.
  pure function power_text(name, power) result(text)
    character(len=*), intent(in) :: name
    integer, intent(in) :: power
    character(len=:), allocatable :: text

    text = ''
    if (power > 0) text = name
    if (power > 1) text = name // achar(iachar('0') + power)
  end function power_text

  ! Unit of length of the scene, or of its height map; empty where neither has one.
  pure function length_unit(scene_in) result(unit)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: unit

    unit = trim(scene_in%units(1))
    if (unit /= '' .or. .not. allocated(scene_in%map)) return
    unit = trim(scene_in%map%lower%unit)
    if (scene_in%map%lower%columns == 0) unit = trim(scene_in%map%upper%unit)
  end function length_unit

  !> Unit of a power of a length: `um2`, `1/um`; empty for a plain number or an unknown unit.
  pure function length_power(unit, power) result(text)
    character(len=*), intent(in) :: unit   !! of the length; empty: unknown
    integer, intent(in) :: power           !! exponent of the length
    character(len=:), allocatable :: text  !! unit of the power

    text = composed_unit(trim(unit), '', unit_powers(length=power))
  end function length_power

  !> A name and its unit in brackets; the name alone where there is none.
  pure function with_unit(name, unit) result(text)
    character(len=*), intent(in) :: name   !! of a quantity
    character(len=*), intent(in) :: unit   !! its name, or blank
    character(len=:), allocatable :: text  !! for instance `load (N)`

    text = name
    if (unit /= '') text = name // ' (' // trim(unit) // ')'
  end function with_unit

end module asperity_unit_names
