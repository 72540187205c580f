!> The controls of a scene: the quantity of a state that `value` in &loading sets, one row each.
!>
!> A row has the word of a scene, the column of the quantity, the target of the model, the unit, the
!> accepted values, and the reasons of bodies that refuse it. A control is added by its row; reader,
!> messages, help, models and summary use the table.
module asperity_loading_controls
  use asperity_kinds, only: real64
  use asperity_numeral, only: above_zero, any_number, not_negative
  use asperity_word_hint, only: one_of
  implicit none
  private

  public :: bodies_asperities, bodies_free_map, bodies_strip, bodies_periodic_map, &
            bodies_flowing_map, bodies_incomplete_map
  public :: loading_control, control_words, control_limit, control_load, control_separation, &
            control_of, accepted_values, compression_of, depth_of, in_model_units, is_compression, &
            is_distance, is_limit, is_load, is_separation, refusal_of, separation_of

  ! Targets of a model: the limit of the first contact; a load; a separation, given as such, by the
  ! compression, or by the mean gap.
  enum, bind(c)
    enumerator :: by_limit, by_load, by_separation, by_compression, by_mean_gap
  end enum

  !> Bodies that may refuse a control: asperities; maps with a free edge, periodic along one axis or
  !> both; periodic ones with a hardness, or with missing pixels.
  enum, bind(c)
    enumerator :: bodies_asperities = 1, bodies_free_map, bodies_strip, bodies_periodic_map, &
                  bodies_flowing_map, bodies_incomplete_map
  end enum

  !> A control.
  type :: loading_control
    character(len=13) :: word = ''       !! in a scene
    character(len=16) :: column = ''     !! column of a state with its quantity
    integer :: target = by_limit         !! one of the targets above
    integer :: powers(2) = 0             !! of its unit: of the modulus, of the length
    logical :: is_vertical = .false.     !! the load is the vertical one
    logical :: is_per_area = .false.     !! the load is the value times the nominal area
    integer :: takes = any_number        !! accepted values, a range of `asperity_numeral`
    character(len=64) :: refused(6) = ''  !! reason by bodies, in the order above; blank: none
  end type loading_control

  character(len=*), parameter :: none = '', pixels_merge = 'patches of pixels merge under load', &
    one_axis = 'a map that is periodic along one axis is known by its load', &
    free_edge = 'a mean gap sets the separation of a periodic map alone'

  type(loading_control), parameter :: controls(*) = [ &
    loading_control('limit', 'separation', by_limit, refused=[character(len=64) :: none, &
                    pixels_merge, pixels_merge, pixels_merge, pixels_merge, pixels_merge]), &
    loading_control('separation', 'separation', by_separation, [0, 1], &
                    refused=[character(len=64) :: none, none, one_axis, none, none, none]), &
    loading_control('load', 'load', by_load, [1, 2], takes=above_zero), &
    loading_control('vertical_load', 'vertical_load', by_load, [1, 2], .true., &
                    takes=above_zero), &
    loading_control('pressure', 'nominal_pressure', by_load, [1, 0], .true., .true., above_zero), &
    loading_control('compression', 'compression', by_compression, [0, 1], takes=not_negative, &
                    refused=[character(len=64) :: none, none, one_axis, none, none, none]), &
    loading_control('mean_gap', 'mean_gap', by_mean_gap, [0, 1], takes=above_zero, &
                    refused=[character(len=64) :: &
                             'between asperities the surfaces have no height', free_edge, &
                             one_axis, none, 'plastic flow changes the mean height', &
                             'missing pixels have no gap'])]

  integer :: row  ! index of the constructor below; flang-19 takes no component of all rows there
  !> The words of a scene, the last one another word for the separation.
  character(len=*), parameter :: control_words(size(controls) + 1) = &
    [character(len=13) :: (controls(row)%word, row=1, size(controls)), 'approach']
  type(loading_control), parameter :: control_limit = controls(1)       !! default of a scene
  type(loading_control), parameter :: control_separation = controls(2)  !! set without a scene
  type(loading_control), parameter :: control_load = controls(3)        !! set without a scene

contains

  !> The control of a word. A refused word stands for the separation, which takes any values.
  pure type(loading_control) function control_of(number)
    integer, intent(in) :: number  !! which of `control_words`; 0: a refused word

    control_of = control_separation
    if (number > 0 .and. number <= size(controls)) control_of = controls(number)
  end function control_of

  !> Whether loading ends where a contact reaches its limit.
  elemental logical function is_limit(control)
    type(loading_control), intent(in) :: control  !! control of a scene

    is_limit = control%target == by_limit
  end function is_limit

  !> Whether a control sets a load.
  elemental logical function is_load(control)
    type(loading_control), intent(in) :: control  !! control of a scene

    is_load = control%target == by_load
  end function is_load

  !> Whether a control sets the separation itself: it is known before the first contact is.
  elemental logical function is_separation(control)
    type(loading_control), intent(in) :: control  !! control of a scene

    is_separation = control%target == by_separation
  end function is_separation

  !> Whether a control sets the compression, from the first contact on.
  elemental logical function is_compression(control)
    type(loading_control), intent(in) :: control  !! control of a scene

    is_compression = control%target == by_compression
  end function is_compression

  !> Whether a control sets the separation in whatever way.
  elemental logical function is_distance(control)
    type(loading_control), intent(in) :: control  !! control of a scene

    is_distance = .not. (is_limit(control) .or. is_load(control))
  end function is_distance

  !> The values that a control accepts, a range of `asperity_numeral`. A load of a path may be 0, a
  !> load of surfaces that attract each other anything.
  pure integer function accepted_values(control, is_path, attracts) result(accepted)
    type(loading_control), intent(in) :: control  !! control of a scene
    logical, intent(in) :: is_path                !! there are several values
    logical, intent(in) :: attracts               !! the scene names an adhesion

    accepted = control%takes
    if (is_load(control) .and. is_path) accepted = not_negative
    if (is_load(control) .and. attracts) accepted = any_number
  end function accepted_values

  !> A value, or its negative where the surfaces are the closer the less it is.
  elemental real(real64) function depth_of(control, value) result(depth)
    type(loading_control), intent(in) :: control  !! control of a scene
    real(real64), intent(in) :: value             !! a value of it

    depth = merge(-value, value, any(control%target == [by_separation, by_mean_gap]))
  end function depth_of

  !> A value in units of powers of 2; a pressure becomes a load.
  elemental real(real64) function in_model_units(control, value, area, modulus_power, &
                                                 length_power) result(number)
    type(loading_control), intent(in) :: control  !! control of a scene
    real(real64), intent(in) :: value             !! a value of it, in units of the scene
    real(real64), intent(in) :: area              !! nominal area [length**2]
    integer, intent(in) :: modulus_power          !! power of the unit of the modulus
    integer, intent(in) :: length_power           !! power of the unit of length

    number = scale(value, -dot_product(control%powers, [modulus_power, length_power]))
    ! Both factors are scaled first, so that the product does not overflow.
    if (control%is_per_area) number = number * scale(area, -2 * length_power)
  end function in_model_units

  !> The compression of asperities that a control of a distance sets.
  elemental real(real64) function compression_of(control, value, first_touch) result(compression)
    type(loading_control), intent(in) :: control  !! one with `is_distance`
    real(real64), intent(in) :: value             !! a value of it
    real(real64), intent(in) :: first_touch       !! separation of the first contact

    compression = value
    if (control%target == by_separation) compression = first_touch - value
  end function compression_of

  !> The separation of a map from the plane that a control of a distance sets. On a periodic map the
  !> mean displacement is 0, so that the mean gap is the separation from the mean height.
  elemental real(real64) function separation_of(control, value, first_touch, mean_height) &
    result(separation)
    type(loading_control), intent(in) :: control  !! one with `is_distance`
    real(real64), intent(in) :: value             !! a value of it
    real(real64), intent(in) :: first_touch       !! separation of the first contact
    real(real64), intent(in) :: mean_height       !! mean height of the pixels

    separation = value
    if (control%target == by_compression) separation = first_touch - value
    if (control%target == by_mean_gap) separation = mean_height + value
  end function separation_of

  !> Why bodies refuse a control, and the words that they accept; empty: they accept it.
  pure function refusal_of(control, bodies) result(text)
    type(loading_control), intent(in) :: control  !! control of a scene
    integer, intent(in) :: bodies                 !! one of the `bodies_` numbers
    character(len=:), allocatable :: text         !! for a message
    integer :: i

    text = trim(control%refused(bodies))
    if (text == '') return
    text = text // ': found control = ''' // trim(control%word) // ''''
    if (is_limit(control)) text = text // ' or none'
    text = text // ', expected ' // &
           one_of(pack(controls%word, [(controls(i)%refused(bodies) == '', i=1, size(controls))]))
  end function refusal_of

end module asperity_loading_controls
