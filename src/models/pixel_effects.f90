!> The effects of a scene on the pixels of a map: what acts on them, and their columns.
module asperity_pixel_effects
  use asperity_attraction_law, only: new_attraction, pixel_steepness
  use asperity_effect_header, only: add_columns, add_effect, area, begin_header, column_name, &
                                    effect_column, effect_header, force, moment, plain
  use asperity_friction, only: slip_contact_columns, slip_state_columns
  use asperity_kinds, only: real64
  use asperity_map_interface, only: conductance_columns, interface_columns
  use asperity_map_state, only: map_laws
  use asperity_problems, only: real_text
  use asperity_scene_values, only: combined_modulus, effect_off, has_hardness, scene
  use asperity_viscoelastic_solid, only: solid_of_scene
  implicit none
  private

  public :: is_attraction_resolved, name_map_columns, resolved_steepness, set_map_laws, steepest

  !> Steepness of the attraction without a warning, and the largest (measured on a ball: up to 1.0
  !> states of open and of adhering surfaces agree to 1e-8 pi w R, at 1.2 they differ by 1e-2; test:
  !> wide pixels in test/maps/test_adhesive_pixels.py).
  real(real64), parameter :: resolved_steepness = 0.7_real64, steepest = 1.2_real64

contains

  !> Sets what acts on the pixels. `failure` is allocated where they are too wide for adhesion.
  subroutine set_map_laws(scene_in, pixel, laws, steepness, failure)
    type(scene), intent(in) :: scene_in         !! scene with a map, checked
    real(real64), intent(in) :: pixel           !! largest spacing of the pixels [length]
    type(map_laws), intent(out) :: laws         !! what acts on the pixels
    real(real64), intent(out) :: steepness      !! of the attraction over a pixel; 0: none
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not resolved

    steepness = 0.0_real64
    associate (effects => scene_in%effects)
      laws%modulus = combined_modulus(scene_in)
      if (has_hardness(scene_in)) laws%hardness = effects%number('plastic_hardness')
      if (effects%mode('adhesion') /= effect_off .and. &
          effects%number('work_of_adhesion') > 0.0_real64) then
        laws%attraction = new_attraction(scene_in)
        steepness = pixel_steepness(laws%attraction, pixel, laws%modulus)
        if (steepness > steepest) &
          failure = 'the pixels are too wide for the range of adhesion: found a spacing of ' // &
                    real_text(pixel) // ', expected at most ' // &
                    real_text(pixel * resolved_steepness / steepness) // &
                    ', or a larger equilibrium_distance'
      end if
      if (effects%mode('creep') /= effect_off) laws%solid = solid_of_scene(scene_in)
    end associate
  end subroutine set_map_laws

  !> Whether the range of adhesion is wide enough for the pixels of a map.
  logical function is_attraction_resolved(scene_in) result(is_resolved)
    type(scene), intent(in) :: scene_in    !! scene with a map and a work of adhesion > 0

    associate (maps => scene_in%map)
      is_resolved = pixel_steepness( &
        new_attraction(scene_in), &
        maxval([maps%lower%pixel_spacing, maps%upper%pixel_spacing]), &
        combined_modulus(scene_in)) <= steepest
    end associate
  end function is_attraction_resolved

  !> Names the columns of a map that is solved on its pixels, beside those of contacts.
  subroutine name_map_columns(scene_in, header)
    type(scene), intent(in) :: scene_in         !! scene with a map that is solved on its pixels
    type(effect_header), intent(out) :: header  !! columns of the effects on pixels
    integer :: i

    call begin_header(header)
    call add_effect(header, 'interaction', scene_in%effects%mode('interaction'))
    call add_columns(header%contact_columns, header%contact_powers, &
                     [effect_column('samples', plain)])
    call add_of_state([effect_column('samples_in_contact', plain), &
                       effect_column('sample_area', area), &
                       effect_column('area_error_estimate', plain), &
                       effect_column('gap_error_estimate', plain), &
                       effect_column('pressure_error_estimate', plain)])
    if (is_on('friction')) then
      call add_columns(header%contact_columns, header%contact_powers, slip_contact_columns)
      call add_of_state(slip_state_columns)
    end if
    call add_of_state(interface_columns)
    do i = 1, 2
      if (abs(scene_in%conductivity(1, i)) > 0.0_real64) &
        call add_of_state([effect_column(conductance_columns(i), plain)])
    end do
    if (any(scene_in%map%form_radius > 0.0_real64)) &
      call add_of_state([effect_column('hertz_pressure', [1, 0]), &
                         effect_column('hertz_area', area)])
    if (has_hardness(scene_in)) then
      call add_effect(header, 'plasticity', scene_in%effects%mode('plasticity'))
      call add_of_state([effect_column('plastic_area', area), &
                         effect_column('dissipated_work', moment)])
      header%hardness = scene_in%effects%number('plastic_hardness')
    end if
    if (is_on('adhesion')) &
      call add_of_state([effect_column('adhering_contacts', plain), &
                         effect_column('pulling_contacts', plain), &
                         effect_column('gap_attraction', force)])
    if (is_on('creep')) &
      call add_of_state([effect_column('time', plain), effect_column('elastic_load', force)])

  contains

    ! Whether an effect is on, which is then added.
    logical function is_on(name)
      character(len=*), intent(in) :: name

      is_on = scene_in%effects%mode(name) /= effect_off
      if (is_on) call add_effect(header, name, scene_in%effects%mode(name))
    end function is_on

    subroutine add_of_state(columns)
      type(column_name), intent(in) :: columns(:)

      call add_columns(header%state_columns, header%state_powers, columns)
    end subroutine add_of_state

  end subroutine name_map_columns

end module asperity_pixel_effects
